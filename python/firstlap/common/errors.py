"""The error a person can act on."""


class InputError(Exception):
    """A file, a name or a value from outside is wrong.

    The message is one line: where, what was wrong, what would be right.
    The command line prints it and exits 2.
    """

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(str(message).split()))


def missing_extra(what: str, package: str, extra: str) -> InputError:
    """What to say where a package that only an extra brings is not installed."""
    return InputError(f"{what} needs {package}: `make extras` in a checkout, or pip install 'firstlap[{extra}]'")
