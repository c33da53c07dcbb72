"""A closed path of evenly spaced points, and the derivatives of its shape by lateral shifts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline

from firstlap.tracks.track import FloatArray


@dataclass(frozen=True, eq=False)
class Path:
    """A closed path, first point not repeated, in the direction of travel.

    points (N, 2) [m]; heading (N,) [rad]; normal (N, 2) pointing left; curvature (N,) [1/m], left positive;
    step (N,) [m] from each point to the next.
    """

    points: FloatArray
    heading: FloatArray
    normal: FloatArray
    curvature: FloatArray
    step: FloatArray

    @property
    def length(self) -> float:
        """Length of a lap in meters."""
        return float(self.step.sum())

    @property
    def stations(self) -> FloatArray:
        """(N,) distance [m] of each point from the first."""
        return np.concatenate([[0.0], np.cumsum(self.step)[:-1]])

    @property
    def poses(self) -> FloatArray:
        """(N, 3) x, y, yaw."""
        return np.column_stack([self.points, self.heading])


def path_through(points: FloatArray) -> Path:
    """The path through evenly spaced points (N, 2), by central differences."""
    after, before = np.roll(points, -1, axis=0), np.roll(points, 1, axis=0)
    first, second = 0.5 * (after - before), after - 2.0 * points + before
    size = np.hypot(*first.T)
    heading = np.arctan2(first[:, 1], first[:, 0])
    return Path(
        points=points,
        heading=heading,
        normal=np.column_stack([-np.sin(heading), np.cos(heading)]),
        curvature=(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / size**3,
        step=np.hypot(*(after - points).T),
    )


def closed_spline(points: FloatArray) -> tuple[CubicSpline, float]:
    """A periodic cubic spline over the chord length through points (N, 2), and that length."""
    closed = np.vstack([points, points[:1]])
    knots = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    return CubicSpline(knots, closed, bc_type="periodic"), float(knots[-1])


def resampled(points: FloatArray, spacing: float, begin: float = 0.0) -> Path:
    """The path resampled at about `spacing`, beginning `begin` meters after the old first point."""
    spline, length = closed_spline(points)
    count = max(16, round(length / spacing))
    return path_through(spline((begin + np.linspace(0.0, length, count, endpoint=False)) % length))


@dataclass(frozen=True, eq=False)
class Response:
    """First derivatives (N, N) of curvature, heading and step with respect to shifts [m] to the left."""

    curvature: sparse.csr_matrix
    heading: sparse.csr_matrix
    step: sparse.csr_matrix


def response(path: Path) -> Response:
    """The derivatives of the path's shape by shifts of its points along their normals."""
    points, normal = path.points, path.normal
    after, before = np.roll(points, -1, axis=0), np.roll(points, 1, axis=0)
    first, second = 0.5 * (after - before), after - 2.0 * points + before
    square = (first**2).sum(axis=1)

    def effect(d_first: FloatArray, d_second: FloatArray) -> tuple[FloatArray, FloatArray]:
        bend = (_cross(d_first, second) + _cross(first, d_second)) / square**1.5
        bend -= 3.0 * path.curvature * (first * d_first).sum(axis=1) / square
        return bend, _cross(first, d_first) / square

    ahead, behind = np.roll(normal, -1, axis=0), np.roll(normal, 1, axis=0)
    bends, turns = zip(
        effect(-0.5 * behind, behind), effect(0.0 * normal, -2.0 * normal), effect(0.5 * ahead, ahead), strict=True
    )
    along = (after - points) / path.step[:, None]
    stretch = (0.0 * path.step, -(along * normal).sum(axis=1), (along * ahead).sum(axis=1))
    return Response(_banded(bends), _banded(turns), _banded(stretch))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _banded(bands: tuple[FloatArray, ...]) -> sparse.csr_matrix:
    """A cyclic tridiagonal matrix."""
    count = len(bands[0])
    here = np.arange(count)
    columns = np.concatenate([(here - 1) % count, here, (here + 1) % count])
    return sparse.csr_matrix((np.concatenate(bands), (np.tile(here, 3), columns)), shape=(count, count))
