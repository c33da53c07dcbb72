"""The interface of a driver: its name, field table, default setup and factory."""

from __future__ import annotations

import difflib
import importlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from firstlap import _core
from firstlap.common.errors import InputError
from firstlap.config.parameters import FieldTable, Values

if TYPE_CHECKING:
    from firstlap.config.car_file import Car
    from firstlap.config.setup_file import Setup
    from firstlap.tracks.track import Track

ProgressCallback = Callable[[str, float], object]
"""Called with the current activity and its progress, 0 to 1, while a driver prepares."""


class Params(Protocol):
    """Parameters by section; implemented by the bindings and by `TableParams`."""

    def get(self, section: str, name: str) -> Any:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """Sets one value. Raises KeyError or ValueError."""

    def values(self) -> dict[str, dict[str, Any]]:
        """{section: {name: value}}."""

    def validate(self) -> None:
        """Raises ValueError if values contradict each other."""


class Handle(Protocol):
    """A driver that is ready to race."""

    @property
    def core(self) -> _core.Driver:
        """The driver that the simulator calls: one of the core, or a `_core.CallbackDriver` around a Python object."""

    @property
    def trace(self) -> dict[str, Any]:
        """The trace of the last step."""


@runtime_checkable
class UsesTruePose(Protocol):
    """A driver that can use the true pose, for ablation."""

    def use_true_pose(self, race: _core.Race | None, track: Track) -> None:
        """Called once before the first step, and with None after the last step."""


@runtime_checkable
class SetsStart(Protocol):
    """A driver that must know its approximate start position."""

    def set_start(self, share: float) -> None:
        """Called before each race. share: distance from the start line to the start position, as a fraction of a
        lap."""


@dataclass(frozen=True)
class Preparation:
    """What a driver prepared before the race, such as a map of the track.

    driving: simulated driving time [s]; computing: CPU time [s]; seconds: their sum; cached: whether everything came
    from the cache; given: the input of the driver's `make`; it must be picklable.
    """

    seconds: float = 0.0
    notes: tuple[str, ...] = ()
    given: Any = None
    driving: float = 0.0
    computing: float = 0.0
    cached: bool = False

    def to_dict(self) -> dict[str, Any]:
        """As in `firstlap race --json`: simulated driving time [s], CPU time [s], and remarks."""
        return {
            "seconds": round(self.seconds, 3),
            "driving": round(self.driving, 3),
            "computing": round(self.computing, 3),
            "cached": self.cached,
            "notes": list(self.notes),
        }


class CoreHandle:
    """A driver of the C++ core."""

    def __init__(self, core: Any) -> None:
        self.core: _core.Driver = core

    @property
    def trace(self) -> dict[str, Any]:
        """The trace of the last step; its fields are listed in the driver's header in cpp/firstlap."""
        return self.core.trace()  # type: ignore[attr-defined]


def _prepare_nothing(
    _track: Track, _setup: Setup, _car: Car, _seed: int, _on_progress: ProgressCallback | None
) -> Preparation:
    return Preparation()


@dataclass(frozen=True)
class DriverKind:
    """One kind of driver.

    new_params: creates the parameters at their defaults. make: creates the driver from its parameters, the car and the
    preparation. prepare: called once per track, direction, setup and car, before the races. in_python: steps hold the
    GIL, so races run in separate processes.
    """

    name: str
    title: str
    fields: FieldTable
    new_params: Callable[[], Params]
    make: Callable[[Any, Car | None, Preparation], Handle]
    default_setup: str
    needs_map: bool = False
    in_python: bool = False
    prepare: Callable[[Track, Setup, Car, int, ProgressCallback | None], Preparation] = field(default=_prepare_nothing)


class TableParams:
    """Parameters of a driver written in Python: the values of its field table."""

    def __init__(self, fields: FieldTable, check: Callable[[Mapping[str, Any]], None] | None = None) -> None:
        self._fields = fields
        self._check = check
        self._values: Values = {(row.section, row.name): row.default for row in fields.fields}

    def get(self, section: str, name: str) -> Any:
        """One value. Raises KeyError."""
        return self._values[section, name]

    def set(self, section: str, name: str, value: float) -> None:
        """Sets one value. Raises KeyError for an unknown name, ValueError for a value outside its range."""
        if (section, name) not in self._values:
            raise KeyError(f"{section}.{name}")
        try:
            checked = self._fields.check(self._fields.find(f"{section}.{name}", "parameters"), value, "parameters")
        except InputError as error:
            raise ValueError(str(error)) from None
        self._values[section, name] = checked

    def values(self) -> dict[str, dict[str, Any]]:
        """All values, {section: {name: value}}."""
        result: dict[str, dict[str, Any]] = {section: {} for section in self._fields.sections}
        for (section, name), value in self._values.items():
            result[section][name] = value
        return result

    def validate(self) -> None:
        """Raises ValueError if values contradict each other."""
        if self._check:
            self._check(self.values())


class Registry(Mapping[str, DriverKind]):
    """Driver kinds by name, in the order of registration.

    package: imported before the first lookup; it registers our own drivers.
    """

    def __init__(self, package: str) -> None:
        self._package = package
        self._kinds: dict[str, DriverKind | Callable[[], DriverKind]] = {}

    def register(self, kind: DriverKind) -> None:
        """Registers a driver, or replaces one of the same name."""
        self._kinds[kind.name] = kind

    def register_lazily(self, name: str, load: Callable[[], DriverKind]) -> None:
        """Registers a driver by its name; `load` is called at its first lookup."""
        self._kinds[name] = load

    def forget(self, name: str) -> None:
        """Unregisters a driver."""
        del self._kinds[name]

    def __getitem__(self, name: str) -> DriverKind:
        kind = self._known()[name]
        if not isinstance(kind, DriverKind):
            kind = self._kinds[name] = kind()
        return kind

    def __contains__(self, name: object) -> bool:
        return name in self._known()

    def __iter__(self) -> Iterator[str]:
        return iter(self._known())

    def __len__(self) -> int:
        return len(self._known())

    def _known(self) -> dict[str, DriverKind | Callable[[], DriverKind]]:
        importlib.import_module(self._package)
        return self._kinds


DRIVERS = Registry("firstlap.drivers")


def driver_kind(name: object, where: str = "--driver") -> DriverKind:
    """The driver of that name. Raises InputError that lists the known names."""
    if isinstance(name, str) and name in DRIVERS:
        return DRIVERS[name]
    near = difflib.get_close_matches(str(name), list(DRIVERS), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"available: {', '.join(DRIVERS)}"
    raise InputError(f"{where}: '{str(name)[:60]}' is not a driver; {hint}")
