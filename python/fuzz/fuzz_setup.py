"""Fuzzes the readers of setup and car files: any text is read or refused with a one-line error."""

import sys

import atheris

with atheris.instrument_imports(include=["firstlap", "yaml"]):
    from firstlap.common.errors import InputError
    from firstlap.config.car_file import parse_car
    from firstlap.config.setup_file import parse_setup


def one_input(data: bytes) -> None:
    """Passes one text to both readers."""
    text = data.decode("utf-8", errors="ignore")
    for parse in (parse_setup, parse_car):
        try:
            parse(text, "fuzz.yaml")
        except InputError as error:  # noqa: PERF203
            assert "\n" not in str(error)


atheris.Setup(sys.argv, one_input)
atheris.Fuzz()
