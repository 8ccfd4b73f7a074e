"""Messages of the sockets, typed once; `python -m console.messages.generate_js` writes the browser's types."""
