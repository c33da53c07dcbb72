"""Workers that race candidates: the cores of this machine, or a Dask cluster; both as `concurrent.futures`."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from multiprocessing import get_context
from typing import Any, Protocol

from firstlap import _core
from firstlap.common.errors import InputError, missing_extra
from firstlap.common.version import __version__
from firstlap.config.parameters import Values
from firstlap.drivers import driver_kind
from firstlap.tuning.candidate import Problem, Verdict, judge

CONNECT_SECONDS = 10.0
WORKERLESS_SECONDS = 20.0
POLL_SECONDS = 0.5
SCHEMES = ("tcp", "tls", "ws", "wss", "ucx", "ucxx")
"""Protocols of Dask addresses."""
Job = tuple[Problem, Values, Sequence[float | None] | None]


class PoolGoneError(Exception):
    """The workers are gone; the message is one line."""


class StoppedError(Exception):
    """The race was interrupted."""


class Pool(Protocol):
    """Races candidates in parallel."""

    workers: int

    def submit(self, job: Job) -> Future[Verdict]:
        """Races one candidate."""

    def check(self) -> None:
        """Called periodically while waiting. Raises PoolGoneError."""

    def close(self) -> None:
        """Ends the running races."""


class LocalPool:
    """The cores of this machine: threads, since the core races without the GIL; processes for drivers in Python."""

    def __init__(self, driver: str, workers: int | None = None) -> None:
        self.workers = workers or os.cpu_count() or 1
        self._stop = threading.Event()
        self._in_python = driver_kind(driver).in_python
        self._executor: Executor = (
            ProcessPoolExecutor(self.workers, mp_context=get_context("spawn"))
            if self._in_python
            else ThreadPoolExecutor(self.workers)
        )

    def submit(self, job: Job) -> Future[Verdict]:
        """Races one candidate."""
        return self._executor.submit(judge, *job, None if self._in_python else self._check_stop)

    def _check_stop(self, _running: _core.Race) -> None:
        if self._stop.is_set():
            raise StoppedError

    def check(self) -> None:
        """Does nothing: this machine is always available."""

    def close(self) -> None:
        """Ends the running races."""
        self._stop.set()
        self._executor.shutdown(wait=True, cancel_futures=True)


class ClusterPool:
    """A Dask cluster. A job whose worker dies is raced again by another worker."""

    def __init__(self, address: str) -> None:
        try:
            import distributed
        except ImportError:
            raise missing_extra("--cluster", "distributed", "tune") from None
        _silence_dask()
        _check_address(address)
        connect: Any = distributed.Client
        try:
            self._client: Any = connect(address, timeout=CONNECT_SECONDS, set_as_default=False)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            raise InputError(f"--cluster {address}: no scheduler answers ({_first_line(error)})") from None
        self._address = address
        self._seen = time.monotonic()
        self._executor = self._client.get_executor(pure=False)
        self.workers = self._wait_for_workers()
        self._check_version()

    def _threads(self) -> int:
        return sum(self._client.nthreads().values())

    def _wait_for_workers(self) -> int:
        end = time.monotonic() + CONNECT_SECONDS
        while not (threads := self._threads()):
            if time.monotonic() > end:
                self.close()
                raise InputError(
                    f"--cluster {self._address}: the cluster has no workers; start some with `dask worker`"
                )
            time.sleep(0.1)
        return threads

    def _check_version(self) -> None:
        try:
            theirs = self._executor.submit(_version).result(timeout=CONNECT_SECONDS * 3)
        except Exception as error:
            self.close()
            raise InputError(
                f"--cluster {self._address}: firstlap does not run on its workers ({_first_line(error)})"
            ) from None
        if theirs != __version__:
            self.close()
            raise InputError(f"--cluster {self._address}: workers have firstlap {theirs}; expected {__version__}")

    def submit(self, job: Job) -> Future[Verdict]:
        """Races one candidate."""
        try:
            return self._executor.submit(judge, *job)
        except Exception as error:
            raise PoolGoneError(f"the cluster {self._address} was lost ({_first_line(error)})") from None

    def check(self) -> None:
        """Raises PoolGoneError if the scheduler is gone, or all workers for some time."""
        try:
            threads = self._threads() if self._client.status == "running" else None
        except Exception:
            threads = None
        if threads is None:
            raise PoolGoneError(f"the cluster {self._address} was lost")
        if threads:
            self._seen = time.monotonic()
        elif time.monotonic() - self._seen > WORKERLESS_SECONDS:
            raise PoolGoneError(f"the cluster {self._address} has had no workers for {WORKERLESS_SECONDS:g} s")

    def close(self) -> None:
        """Disconnects from the cluster."""
        try:
            self._client.close(timeout=2.0)
        except Exception:
            logging.getLogger(__name__).debug("the cluster did not disconnect properly", exc_info=True)


def make_pool(driver: str, cluster: str | None, workers: int | None) -> LocalPool | ClusterPool:
    """Makes the pool. Raises InputError if the cluster cannot be reached."""
    return LocalPool(driver, workers) if cluster is None else ClusterPool(cluster)


def race_all(pool: Pool, jobs: Sequence[Job], done: Callable[[int, Verdict], object]) -> list[Verdict]:
    """All results in the order of the jobs; `done` is called in this thread for each. Raises PoolGoneError."""
    futures = {pool.submit(job): index for index, job in enumerate(jobs)}
    found: dict[int, Verdict] = {}
    try:
        for future in _as_they_come(pool, set(futures)):
            found[futures[future]] = _result(future)
            done(futures[future], found[futures[future]])
    except BaseException:
        for future in futures:
            future.cancel()
        raise
    return [found[index] for index in range(len(jobs))]


def _as_they_come(pool: Pool, waiting: set[Future[Verdict]]) -> Iterator[Future[Verdict]]:
    while waiting:
        ready, waiting = wait(waiting, timeout=POLL_SECONDS, return_when=FIRST_COMPLETED)
        if not ready:
            pool.check()
        yield from ready


def _result(future: Future[Verdict]) -> Verdict:
    try:
        return future.result()
    except CancelledError:
        raise PoolGoneError("the cluster was lost (it canceled a candidate)") from None
    except Exception as error:
        if type(error).__module__.startswith("distributed"):
            raise PoolGoneError(f"the cluster gave up a candidate ({_first_line(error)})") from None
        raise


def _check_address(address: str) -> None:
    """Raises InputError for an invalid address, on which a Dask client would take long to fail."""
    place, colon, port = address.rpartition(":")
    scheme, separator, host = place.rpartition("://")
    whole = bool(host) and bool(colon) and port.isascii() and port.isdigit() and int(port) < 65536
    if not whole or (separator and scheme not in SCHEMES):
        raise InputError(f"--cluster {address[:80]}: expected an address like tcp://192.168.1.10:8786")


def _silence_dask() -> None:
    """Silences Dask's log messages about lost connections, which we report in one line."""
    for name in list(logging.root.manager.loggerDict):
        if name.startswith(("distributed", "tornado")):
            logging.getLogger(name).setLevel(logging.CRITICAL)


def _version() -> str:
    import firstlap

    return firstlap.__version__


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:120]
