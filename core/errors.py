"""The errors of Beckon: every one is a sentence for the person who can act on it.

BeckonError
├── BadInput        a file, a number or a text cannot be used; the sentence says why and what to do
│   └── BadSettings an option or a setting of the program is wrong: its use, not its data
├── Unavailable     something needed is not there (a robot, a package, a device)
│   └── Unwritable  the disk does not take what must be kept (full, read-only, no permission, gone)
└── Refused         understood, but not allowed now (out of bounds, no lease, latched)
"""


class BeckonError(Exception):
    """Base of all errors whose sentence is shown to people unchanged."""

    def __str__(self) -> str:  # a sentence keeps its code
        return str(self.args[0]) if self.args else ""


class BadInput(BeckonError):
    """A file, a number or a text that cannot be used."""


class BadSettings(BadInput):
    """Settings that do not exist or have no such value: wrong usage."""


class Unavailable(BeckonError):
    """Something needed is not there: a robot, a package, a device."""


class Unwritable(Unavailable):
    """The disk does not take what must be kept; the sentence says what, why and what to do."""


class Refused(BeckonError):
    """Understood, but not allowed now."""
