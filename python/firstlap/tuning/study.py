"""Studies: all finished trials of a search, in one SQLite file for optuna-dashboard."""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstlap.common.errors import InputError, missing_extra
from firstlap.common.file_lock import locked
from firstlap.common.files import check_readable
from firstlap.config.parameters import Values
from firstlap.tracks.track import Track
from firstlap.tuning.candidate import Verdict
from firstlap.tuning.space import Space

ABOUT = "firstlap"
SQLITE_HEAD = b"SQLite format 3\0"
OUR_TABLES = {"studies", "trials", "version_info"}
CANNOT_WRITE = ("disk is full", "disk I/O error", "readonly database", "unable to open", "is locked", "File too large")
"""Error messages of sqlite that are caused by the disk, not by the file's content."""
PATIENCE = 20
"""[s] Timeout for another process that is writing the file."""


@dataclass(frozen=True)
class Trial:
    """One finished candidate. number: its index in the search. start: the name of the starting setup that it is, or
    empty.

    seconds: duration of the search when it finished.
    """

    number: int
    given: Values
    verdict: Verdict
    cost: float
    start: str = ""
    seconds: float = 0.0


class Study:
    """The trials of one search. An added trial is on disk when `add` returns."""

    def __init__(self, study: Any, path: Path) -> None:
        """study: optuna's, in the file `path`. Raises InputError if it is invalid."""
        self._study = study
        self._path = path
        self.trials: dict[int, Trial] = {}
        with _storage_errors(path):
            for stored in study.get_trials(deepcopy=False):
                trial = _read(stored, f"{path}: study '{study.study_name}'")
                if trial:
                    self.trials[trial.number] = trial

    @property
    def name(self) -> str:
        """The name, as given by --name."""
        return str(self._study.study_name)

    @property
    def about(self) -> dict[str, Any]:
        """The attributes of the search."""
        return dict(self._study.user_attrs.get(ABOUT, {}))

    @property
    def seconds(self) -> float:
        """Duration of the search so far [s]."""
        return max((trial.seconds for trial in self.trials.values()), default=0.0)

    @property
    def laps(self) -> float:
        """Laps simulated so far, including partial ones."""
        return sum(trial.verdict.driven for trial in self.trials.values())

    @property
    def ordered(self) -> list[Trial]:
        """All trials in the order of the search."""
        return [self.trials[number] for number in sorted(self.trials)]

    def add(self, trial: Trial, space: Space) -> None:
        """Stores a finished trial; an existing one is kept. Raises InputError."""
        import optuna

        if trial.number in self.trials:
            return
        finished = optuna.trial.create_trial(
            value=trial.cost,
            params=_params(trial, space),
            distributions=_distributions(space),
            user_attrs=_attributes(trial),
        )
        with _storage_errors(self._path):
            self._study.add_trial(finished)
        self.trials[trial.number] = trial

    def parameters_that_mattered(self) -> dict[str, float]:
        """{section.name: share} by PED-ANOVA (Watanabe et al. 2023), largest first; empty with too few trials."""
        import warnings

        import optuna

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                found = optuna.importance.get_param_importances(
                    self._study, evaluator=optuna.importance.PedAnovaImportanceEvaluator()
                )
            except (RuntimeError, ValueError):
                return {}
        return {name: float(share) for name, share in found.items()}


def open_study(path: Path, name: str, about: dict[str, Any]) -> Study:
    """The study of that name in the file; created if it does not exist. Raises InputError.

    about: the attributes of the search; a study with other attributes is refused.
    """
    check_study_file(path)
    optuna = quiet_optuna()
    with _opening(path), _storage_errors(path):
        storage = optuna.storages.RDBStorage(f"sqlite:///{path}", engine_kwargs={"connect_args": {"timeout": PATIENCE}})
        study = optuna.create_study(storage=storage, study_name=name, load_if_exists=True)
        if not study.user_attrs and not study.get_trials(deepcopy=False):
            study.set_user_attr(ABOUT, about)
        found = study.user_attrs.get(ABOUT)
    if not isinstance(found, dict):
        raise InputError(f"{path}: study '{name}' was not made by firstlap; use another --name")
    _compare(found, json.loads(json.dumps(about)), path, name)
    return Study(study, path)


def check_study_file(path: Path) -> None:
    """Raises InputError if the file exists but is not a study file, or cannot be written; changes nothing."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected a file name for the studies")
    if not path.parent.is_dir():
        raise InputError(f"{path}: no such folder {path.parent}")
    if not os.access(path.parent, os.W_OK) or (path.exists() and not os.access(path, os.R_OK | os.W_OK)):
        raise InputError(f"{path}: cannot be written")
    with _opening(path):
        if not path.exists():
            return
        check_readable(path, "a file of studies")
        with path.open("rb") as file:
            head = file.read(len(SQLITE_HEAD))
        if head and (head != SQLITE_HEAD or not _tables(path) >= OUR_TABLES):
            raise InputError(f"{path}: is not a study file (expected the SQLite file of an earlier `firstlap tune`)")


def study_names(path: Path) -> list[str]:
    """Names of the studies in a file; empty if it does not exist. Raises InputError."""
    check_study_file(path)
    if not path.exists() or path.stat().st_size == 0:
        return []
    with _storage_errors(path), closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        return [str(row[0]) for row in connection.execute("select study_name from studies order by study_id")]


@contextmanager
def only_one(path: Path, name: str) -> Iterator[None]:
    """Locks the study for this process. Raises InputError if another process has it."""
    digest = hashlib.sha256(name.encode()).hexdigest()[:8]
    busy = f"{path}: study '{name}' is being tuned by another process"
    with locked(path, digest, busy):
        yield


@contextmanager
def _opening(path: Path) -> Iterator[None]:
    """Locks the file while its tables are created or checked, so that no process sees an incomplete file."""
    with locked(path, "opening", "", wait=True):
        yield


@contextmanager
def _storage_errors(path: Path) -> Iterator[None]:
    """Converts storage errors of the file `path` to InputError."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # sqlite, sqlalchemy and optuna may raise any exception for a damaged file
        raise InputError(f"{path}: {_what_failed(error)}") from None


def _what_failed(error: Exception) -> str:
    reason = _last_line(error)
    if isinstance(error, RuntimeError) and "version" in str(error):
        return f"a study file of another version of optuna ({reason})"
    if any(word in reason for word in CANNOT_WRITE):
        return f"cannot be written ({reason})"
    return f"is damaged, or not a study of firstlap ({type(error).__name__}: {reason})"


def track_digest(track: Track) -> str:
    """Hash of the track's walls, line and direction."""
    digest = hashlib.sha256()
    for array in track.to_arrays().values():
        digest.update(array.tobytes())  # type: ignore[attr-defined]
    return digest.hexdigest()[:16]


def quiet_optuna() -> Any:
    """Imports optuna and silences its log messages. Raises InputError if it is not installed."""
    try:
        import cmaes  # noqa: F401
        import optuna
    except ImportError:
        raise missing_extra("tuning", "optuna", "tune") from None
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna


def _compare(found: dict[str, Any], wanted: dict[str, Any], path: Path, name: str) -> None:
    if found.get("track_digest") != wanted.get("track_digest"):
        raise InputError(
            f"{path}: study '{name}' is for another track ({found.get('track')}, {found.get('direction')}); "
            "use another --name"
        )
    different = [key for key in wanted if found.get(key) != wanted[key] and key not in ("track", "version")]
    if different:
        raise InputError(
            f"{path}: study '{name}' was begun with another {', '.join(different)}; use the same, or another --name"
        )


def _tables(path: Path) -> set[str]:
    try:
        with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
            return {str(row[0]) for row in connection.execute("select name from sqlite_master where type = 'table'")}
    except sqlite3.Error:
        return set()


def _params(trial: Trial, space: Space) -> dict[str, float]:
    params = {}
    for axis in space.axes:
        value = trial.given.get((axis.field.section, axis.field.name), axis.field.default)
        number = float(min(max(float(value), axis.low), axis.high))
        params[axis.field.key] = number if axis.field.type == "float" else int(number)
    return params


def _distributions(space: Space) -> dict[str, Any]:
    import optuna

    return {
        axis.field.key: optuna.distributions.FloatDistribution(axis.low, axis.high, log=axis.log)
        if axis.field.type == "float"
        else optuna.distributions.IntDistribution(int(axis.low), int(axis.high), log=axis.log)
        for axis in space.axes
    }


def _attributes(trial: Trial) -> dict[str, Any]:
    verdict = trial.verdict
    return {
        "number": trial.number,
        "start": trial.start,
        "seconds": trial.seconds,
        "given": {f"{section}.{name}": value for (section, name), value in trial.given.items()},
        "lap": verdict.lap,
        "holds": verdict.holds,
        "clearance": verdict.clearance,
        "failed": f"{verdict.failed} of {verdict.raced}",
        "verdict": verdict.to_dict(),
    }


def _read(stored: Any, where: str) -> Trial | None:
    """Reads one trial; None if it was not made by firstlap. Raises InputError if it was modified."""
    attributes = stored.user_attrs
    if "verdict" not in attributes or stored.value is None:
        return None
    try:
        return Trial(
            number=int(attributes["number"]),
            given=_given(attributes["given"]),
            verdict=Verdict.from_dict(attributes["verdict"]),
            cost=float(stored.value),
            start=str(attributes["start"]),
            seconds=float(attributes["seconds"]),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        reason = f"{type(error).__name__}: {error}"[:120]
        raise InputError(f"{where}: trial {stored.number} was modified or damaged ({reason})") from None


def _given(stored: dict[str, Any]) -> Values:
    given: Values = {}
    for key, value in stored.items():
        section, _, name = key.partition(".")
        if not isinstance(value, int | float):
            raise TypeError(f"{key} is {str(value)[:40]}")
        given[section, name] = value
    return given


def _last_line(error: BaseException) -> str:
    cause = error.__cause__ or error
    return (str(cause).strip().splitlines() or [type(cause).__name__])[0][:120]
