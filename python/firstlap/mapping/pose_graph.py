"""Pose-graph optimization of all matches and odometry, with gtsam."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstlap.common.errors import InputError, missing_extra
from firstlap.mapping.slam import Edge, Mapper
from firstlap.tracks.track import FloatArray

ROBUST = 3.0  # standard deviations beyond which a match is downweighted


def load_gtsam() -> Any:
    """The gtsam module. Raises InputError if the extra is not installed."""
    try:
        import gtsam
    except ImportError:
        raise missing_extra("mapping", "gtsam", "global") from None
    return gtsam


def optimize(mapper: Mapper, edges: list[Edge], poses: FloatArray, scale: float) -> FloatArray:
    """(N, 3) optimal poses of the keyframes given matches, loops and odometry; the first stays at 0.

    poses: (N, 3) initial values. scale: of the odometry's distance.
    """
    gtsam = load_gtsam()
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    graph.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)))
    for i, keyframe in enumerate(mapper.keyframes):
        values.insert(i, gtsam.Pose2(*poses[i]))
        if i:
            odometry = keyframe.odometry * [scale, scale, 1.0]
            sigmas = np.array(mapper.odometry_sigmas(keyframe.odometry))
            noise = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
            graph.add(gtsam.BetweenFactorPose2(i - 1, i, gtsam.Pose2(*odometry), noise))
    weight = mapper.settings.get("graph.match_weight")
    for edge in edges:
        information = weight * edge.information + 1e-6 * np.eye(3)
        noise = gtsam.noiseModel.Gaussian.Information(0.5 * (information + information.T))
        kernel = gtsam.noiseModel.mEstimator.Cauchy.Create(ROBUST)
        robust = gtsam.noiseModel.Robust.Create(kernel, noise)
        graph.add(gtsam.BetweenFactorPose2(edge.first, edge.last, gtsam.Pose2(*edge.pose), robust))
    try:
        solved = gtsam.LevenbergMarquardtOptimizer(graph, values).optimize()
    except RuntimeError as error:
        raise InputError(f"the pose graph has no solution ({str(error).splitlines()[0]})") from None
    found = [solved.atPose2(i) for i in range(len(mapper.keyframes))]
    return np.array([[pose.x(), pose.y(), pose.theta()] for pose in found])
