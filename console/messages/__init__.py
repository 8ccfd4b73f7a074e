"""Messages of the sockets, typed once; `python -m tests.reference` writes the browser's types."""
