"""What a driver is to those who do not know it: its name, its field table, its setup, and how it is made."""

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
"""Called with what is being done and its share, 0 to 1, while a driver prepares itself."""


class Params(Protocol):
    """Sections of parameters, as the bindings and `TableParams` have them."""

    def get(self, section: str, name: str) -> Any:
        """One value. Raises KeyError."""

    def set(self, section: str, name: str, value: float) -> None:
        """Sets one value. Raises KeyError or ValueError."""

    def values(self) -> dict[str, dict[str, Any]]:
        """{section: {name: value}}."""

    def validate(self) -> None:
        """Raises ValueError where values contradict each other."""


class Handle(Protocol):
    """A driver that is ready to race."""

    @property
    def core(self) -> _core.Driver:
        """What the simulator calls: a driver of the core, or a `_core.CallbackDriver` around a Python object."""

    @property
    def trace(self) -> dict[str, Any]:
        """What the last step saw and thought."""


@runtime_checkable
class UsesTruePose(Protocol):
    """A driver that an ablation may give the true pose."""

    def use_true_pose(self, race: _core.Race | None, track: Track) -> None:
        """Called once before the first step; after the last without a race."""


@runtime_checkable
class SetsStart(Protocol):
    """A driver that must know about where it is put down."""

    def set_start(self, share: float) -> None:
        """Called before each race: the share of a lap from the track's start line to the place."""


@dataclass(frozen=True)
class Preparation:
    """What a driver that needs a map made of the track before the race.

    seconds: of simulated driving and of computing that it took, together; driving, computing: each of them; cached:
    whether all of it was there from before; given: whatever its `make` wants; it must pickle.
    """

    seconds: float = 0.0
    notes: tuple[str, ...] = ()
    given: Any = None
    driving: float = 0.0
    computing: float = 0.0
    cached: bool = False

    def to_dict(self) -> dict[str, Any]:
        """As `firstlap race --json` prints it: seconds of simulated driving and of processor time, and remarks."""
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
        """What the last step saw and thought, see the driver's header in cpp/firstlap."""
        return self.core.trace()  # type: ignore[attr-defined]


def _prepare_nothing(
    _track: Track, _setup: Setup, _car: Car, _seed: int, _look: ProgressCallback | None
) -> Preparation:
    return Preparation()


@dataclass(frozen=True)
class DriverKind:
    """One kind of driver.

    new_params: all parameters at their defaults. make: the driver, from its parameters (`Params`), the car and what it
    prepared. prepare: called once per track, direction, setup and car, before the races. in_python: steps take the GIL,
    so that races of it run in processes.
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
    """Parameters of a driver that is written in Python: the values of its field table."""

    def __init__(self, fields: FieldTable, check: Callable[[Mapping[str, Any]], None] | None = None) -> None:
        self._fields = fields
        self._check = check
        self._values: Values = {(row.section, row.name): row.default for row in fields.fields}

    def get(self, section: str, name: str) -> Any:
        """One value. Raises KeyError."""
        return self._values[section, name]

    def set(self, section: str, name: str, value: float) -> None:
        """Sets one value. Raises KeyError for an unknown name, ValueError for a value out of its range."""
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
        """Raises ValueError where values contradict each other."""
        if self._check:
            self._check(self.values())


class Registry(Mapping[str, DriverKind]):
    """name -> kind, in the order in which they became known.

    package: registers our own drivers when it is imported, which is done before the first look.
    """

    def __init__(self, package: str) -> None:
        self._package = package
        self._kinds: dict[str, DriverKind | Callable[[], DriverKind]] = {}

    def register(self, kind: DriverKind) -> None:
        """Makes a driver known, or known anew."""
        self._kinds[kind.name] = kind

    def register_lazily(self, name: str, load: Callable[[], DriverKind]) -> None:
        """Makes a driver known by its name; the rest of it is loaded when it is asked for."""
        self._kinds[name] = load

    def forget(self, name: str) -> None:
        """Makes a driver unknown."""
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
    """The driver of that name. Raises InputError with the known ones."""
    if isinstance(name, str) and name in DRIVERS:
        return DRIVERS[name]
    near = difflib.get_close_matches(str(name), list(DRIVERS), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else f"drivers are {', '.join(DRIVERS)}"
    raise InputError(f"{where}: '{str(name)[:60]}' is no driver; {hint}")
