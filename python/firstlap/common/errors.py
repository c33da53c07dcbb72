"""Errors that the user can fix."""


class InputError(Exception):
    """A file, a name or a value from the user is invalid.

    The message is one line: where, what is wrong, what would be right.
    The command line prints it and exits with code 2.
    """

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(str(message).split()))


def missing_extra(what: str, package: str, extra: str) -> InputError:
    """The error for a missing package that is installed by an extra."""
    return InputError(f"{what} needs {package}: `make extras` in a checkout, or pip install 'firstlap[{extra}]'")
