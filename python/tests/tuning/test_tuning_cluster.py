"""Tuning on a Dask cluster with real worker processes, some of which die."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from test_tuning import found, plain, session_of

import firstlap
from firstlap.common.errors import InputError
from firstlap.tuning import pool as pools
from firstlap.tuning.pool import ClusterPool, PoolGoneError
from firstlap.tuning.search import Budget, Search
from firstlap.tuning.study import open_study

distributed = pytest.importorskip("distributed", reason="the extra `tune` is not installed")
pytestmark = pytest.mark.filterwarnings("ignore")
TRIALS = 9


def cluster(workers: int, processes: bool):
    return distributed.LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=processes,
        protocol="tcp://",
        dashboard_address=None,
        silence_logs=50,
    )


def search_on(address: str, path: Path, track: firstlap.Track, at_trial: dict):
    session = session_of(track)
    study = open_study(path, "a", session.about())
    pool = ClusterPool(address)
    kept = []

    def done(trial):
        kept.append(trial.number)
        at_trial.pop(len(kept), lambda: None)()

    try:
        search = Search(session.problem(), session.starts[:1], session.space, study, pool, 1, session.population)
        search.done = done
        search.run(Budget(trials=TRIALS))
    finally:
        pool.close()
        study.counted = kept
    return study


def test_a_worker_killed_in_the_middle_costs_only_time(tmp_path: Path):
    oval = firstlap.load_track("oval")
    with cluster(2, processes=True) as workers:
        victims = [worker.pid for worker in workers.workers.values()]
        assert os.getpid() not in victims
        kill = {5: lambda: os.kill(victims[0], signal.SIGKILL)}
        study = search_on(workers.scheduler_address, tmp_path / "a.db", oval, kill)
    assert not kill
    assert sorted(study.counted) == list(range(TRIALS))
    assert len(open_study(tmp_path / "a.db", "a", study.about).ordered) == TRIALS
    assert plain(study.ordered) == plain(found(oval, tmp_path / "b.db", TRIALS))


@pytest.mark.parametrize("way", ["everything", "all workers"])
def test_a_cluster_that_goes_away_leaves_what_was_finished(tmp_path: Path, way: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(pools, "WORKERLESS_SECONDS", 0.5)
    oval = firstlap.load_track("oval")
    workers = cluster(1, processes=False)
    end = workers.close if way == "everything" else lambda: workers.scale(0)
    try:
        with pytest.raises(PoolGoneError, match="was lost" if way == "everything" else "no workers"):
            search_on(workers.scheduler_address, tmp_path / "a.db", oval, {4: end})
    finally:
        workers.close()
    kept = open_study(tmp_path / "a.db", "a", session_of(oval).about()).ordered
    assert 4 <= len(kept) < TRIALS
    assert plain(found(oval, tmp_path / "a.db", TRIALS))[: len(kept)] == plain(kept)


def test_a_cluster_that_is_not_there_is_one_clear_line(cli, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(pools, "CONNECT_SECONDS", 0.3)
    for address in (
        "nonsense://there:1",
        "127.0.0.1:notaport",
        "there",
        "tcp://:8786",
        "tcp://a:99999",
        "",
        ":",
        "a:²",
    ):
        with pytest.raises(InputError, match=r"--cluster .*expected an address like"):
            ClusterPool(address)
    for address in ("tcp://127.0.0.1:9", "127.0.0.1:9"):
        with pytest.raises(InputError, match="no scheduler answers"):
            ClusterPool(address)
    ran = cli("tune", "oval", "--budget", 1, "--cluster", "tcp://127.0.0.1:9")
    assert ran.code == 2
    assert ran.err.startswith("error: --cluster tcp://127.0.0.1:9")
    assert len(ran.err.strip().splitlines()) == 1
