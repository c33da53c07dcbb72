"""Studies: every finished trial of a search, in one SQLite file that optuna-dashboard opens."""

from __future__ import annotations

import fcntl
import hashlib
import json
import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstlap.errors import InputError, missing_extra
from firstlap.parameters import Values
from firstlap.tracks.track import Track
from firstlap.tuning.candidate import Verdict
from firstlap.tuning.space import Space

ABOUT = "firstlap"
SQLITE_HEAD = b"SQLite format 3\0"
OUR_TABLES = {"studies", "trials", "version_info"}


@dataclass(frozen=True)
class Trial:
    """One finished candidate. number: its place in the search. start: the name of the setup that it is, or nothing.

    seconds: of the whole search, when it was finished.
    """

    number: int
    given: Values
    verdict: Verdict
    cost: float
    start: str = ""
    seconds: float = 0.0


class Study:
    """The trials of one search. What is added is on the disk when `add` returns."""

    def __init__(self, study: Any, space: Space | None = None) -> None:
        self._study = study
        self._space = space
        self.trials: dict[int, Trial] = {}
        for stored in study.get_trials(deepcopy=False):
            trial = _read(stored)
            if trial:
                self.trials[trial.number] = trial

    @property
    def name(self) -> str:
        """As of --name."""
        return str(self._study.study_name)

    @property
    def about(self) -> dict[str, Any]:
        """What is searched."""
        return dict(self._study.user_attrs.get(ABOUT, {}))

    @property
    def seconds(self) -> float:
        """Of search so far."""
        return max((trial.seconds for trial in self.trials.values()), default=0.0)

    @property
    def laps(self) -> float:
        """Simulated so far, parts included."""
        return sum(trial.verdict.driven for trial in self.trials.values())

    @property
    def ordered(self) -> list[Trial]:
        """All trials in the order of the search."""
        return [self.trials[number] for number in sorted(self.trials)]

    def add(self, trial: Trial, space: Space) -> None:
        """Keeps a finished trial; one that is there already stays as it is."""
        import optuna

        if trial.number in self.trials:
            return
        self._study.add_trial(
            optuna.trial.create_trial(
                value=trial.cost,
                params=_params(trial, space),
                distributions=_distributions(space),
                user_attrs=_attributes(trial),
            )
        )
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
    """The study of that name in the file, made where it is not there. Raises InputError.

    about: what is searched; a study that was made for something else is refused.
    """
    check_study_file(path)
    optuna = quiet_optuna()
    try:
        storage = optuna.storages.RDBStorage(f"sqlite:///{path}", engine_kwargs={"connect_args": {"timeout": 20}})
        study = optuna.create_study(storage=storage, study_name=name, load_if_exists=True)
        if not study.user_attrs and not study.get_trials(deepcopy=False):
            study.set_user_attr(ABOUT, about)
        found = study.user_attrs.get(ABOUT)
    except (optuna.exceptions.StorageInternalError, OSError, sqlite3.Error) as error:
        raise InputError(f"{path}: cannot be written ({_last_line(error)})") from None
    except RuntimeError as error:
        raise InputError(f"{path}: a study file of another version of optuna ({_last_line(error)})") from None
    if found is None:
        raise InputError(f"{path}: study '{name}' is not one of firstlap's; expected another --name")
    _compare(found, json.loads(json.dumps(about)), path, name)
    return Study(study)


def check_study_file(path: Path) -> None:
    """Raises InputError where the file is there and no study file, or cannot be written."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected a file name for the studies")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
    try:
        new = not path.exists() or path.stat().st_size == 0
        with path.open("ab"):
            pass
        if new:
            path.unlink()
            return
        with path.open("rb") as file:
            head = file.read(len(SQLITE_HEAD))
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    if head != SQLITE_HEAD or not _tables(path) >= OUR_TABLES:
        raise InputError(f"{path}: is not a file of studies (expected the SQLite file of an earlier `firstlap tune`)")


def study_names(path: Path) -> list[str]:
    """Names of the studies in a file; none where it is not there. Raises InputError."""
    check_study_file(path)
    if not path.exists():
        return []
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as connection:
        return [str(row[0]) for row in connection.execute("select study_name from studies order by study_id")]


@contextmanager
def only_one(path: Path, name: str) -> Iterator[None]:
    """Holds the study for this process. Raises InputError where another one has it."""
    digest = hashlib.sha256(name.encode()).hexdigest()[:8]
    lock = path.with_name(f".{path.name}.{digest}.lock")
    with ExitStack() as held:
        try:
            file = held.enter_context(lock.open("w"))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{path}: study '{name}' is being tuned by another process") from None
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror})") from None
        held.callback(lock.unlink, missing_ok=True)
        yield


def track_digest(track: Track) -> str:
    """The same for the same walls, line and direction."""
    digest = hashlib.sha256()
    for array in track.to_arrays().values():
        digest.update(array.tobytes())  # type: ignore[attr-defined]
    return digest.hexdigest()[:16]


def quiet_optuna() -> Any:
    """optuna without its own words. Raises InputError where it is not installed."""
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
            f"{path}: study '{name}' is of another track ({found.get('track')}, {found.get('direction')}); "
            "expected another --name"
        )
    different = [key for key in wanted if found.get(key) != wanted[key] and key not in ("track", "version")]
    if different:
        raise InputError(
            f"{path}: study '{name}' was begun with another {', '.join(different)}; "
            "expected the same, or another --name"
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


def _read(stored: Any) -> Trial | None:
    attributes = stored.user_attrs
    if "verdict" not in attributes or stored.value is None:
        return None
    given: Values = {}
    for key, value in attributes["given"].items():
        section, _, name = key.partition(".")
        given[section, name] = value
    return Trial(
        number=attributes["number"],
        given=given,
        verdict=Verdict(**attributes["verdict"]),
        cost=stored.value,
        start=attributes["start"],
        seconds=attributes["seconds"],
    )


def _last_line(error: BaseException) -> str:
    cause = error.__cause__ or error
    return (str(cause).strip().splitlines() or [type(cause).__name__])[0][:120]
