"""Choosing driver and setup, and saving the setup."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from viser import Icon

from firstlap.config.driver_kind import DRIVERS, driver_kind
from firstlap.config.setup_file import Setup, list_setups, load_setup
from firstlap.pitwall.saving import save_setup
from firstlap.pitwall.source import Simulates, Source
from firstlap.pitwall.viewer_session import ViewerSession, assign


def drivers(source: Source) -> list[str]:
    """Names of the available drivers; a driver that needs a map is only available in the simulator."""
    return [name for name in DRIVERS if isinstance(source, Simulates) or not driver_kind(name).needs_map]


class SetupPanel:
    """Built in the current gui container. folder: where setups are saved."""

    def __init__(self, session: ViewerSession, source: Source, folder: Path) -> None:
        self._session = session
        self._source = source
        self._folder = folder
        self._files: dict[str, Path] = {}
        gui = session.gui
        loaded = source.loaded
        names = drivers(source)
        options = names if loaded.driver in names else [loaded.driver, *names]
        self._driver = gui.add_dropdown("driver", options, initial_value=loaded.driver, hint=self._titles(names))
        self._driver.on_update(session.choice("driver", self._choose_driver, self.load))
        self._setup = gui.add_dropdown(
            "setup", [loaded.name], hint="built-in setups, the loaded one, and those saved here"
        )
        self._setup.on_update(session.choice("setup", self._choose_setup, self.load))
        with gui.add_folder("Save"):
            self._name = gui.add_text("name", "", hint="name of the new setup file, without .yaml")
            self._replace = gui.add_checkbox("replace", False, hint="overwrite an existing file of that name")
            gui.add_button("Save setup", icon=Icon.DEVICE_FLOPPY).on_click(session.click("save", self._save))
        self.load()

    def load(self) -> None:
        """Shows the loaded driver and setup."""
        loaded = self._source.loaded
        options = self._names(loaded)
        if tuple(self._setup.options) != tuple(options):
            self._setup.options = options
        shown: tuple[tuple[Any, str], ...] = ((self._driver, loaded.driver), (self._setup, loaded.name))
        for handle, value in shown:
            assign(handle, "value", value)

    def _names(self, loaded: Setup) -> list[str]:
        names = list_setups(loaded.driver)
        names += [name for name in self._files if name not in names]
        return names if loaded.name in names else [loaded.name, *names]

    @staticmethod
    def _titles(names: list[str]) -> str:
        return "; ".join(f"{name}: {driver_kind(name).title}" for name in names)

    def _choose_driver(self, name: str) -> None:
        kind = driver_kind(name)
        self._source.choose(load_setup(kind.default_setup, kind.name))

    def _choose_setup(self, name: str) -> None:
        loaded = self._source.loaded
        # The loaded setup may be from a file of which only the name is known.
        self._source.choose(loaded if name == loaded.name else load_setup(self._files.get(name, name)))

    def _save(self) -> None:
        source = self._source
        name, title = self._name.value, source.title
        path = save_setup(source.setup, source.loaded, self._folder, name, title, self._replace.value)
        self._files[path.stem] = path
        assign(self._replace, "value", False)
        self.load()
        self._session.notify(f"saved {path.name}", f"race it: firstlap race TRACK --setup {path.name}")
