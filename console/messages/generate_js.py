"""`python -m tests.reference` under its former name, in a checkout."""

import runpy

if __name__ == "__main__":
    runpy.run_module("tests.reference", run_name="__main__")
