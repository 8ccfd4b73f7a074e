"""Coarse measurements give way where finer ones hold the same views: wheels err alike at every turn, walls do not."""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from core.message import Array
from core.slam.map.pose_graph import EdgeTable, whitening

EVEN = np.diag([0.06, 0.06, math.radians(1.3)])  # [m], [rad] sd from fine edges for which as much doubt is added
LARGEST = 1.0  # [m²], [rad²]: what is less certain than that says nothing that could give way


def reweighted(coarse: EdgeTable, fine: EdgeTable, headings: Array) -> EdgeTable:
    """Coarse edges, believed the less the more the fine ones tell of both their ends; world headings (N,) [rad].

    C + EVEN² I EVEN², I the information that both ends have from the fine edges, where a way along these leads from
    one end to the other. It goes direction by direction: along a bare corridor, where walls tell nothing, C remains.
    What is systematic in the wheels (a laser that stands aside of where the robot turns) is in every coarse edge and
    does not average out, and the coarse edges may claim millimetres: weighed by that, they would bend the fine ones.
    """
    if not len(fine) or not len(coarse):
        return coarse
    part, information = _parts(fine, len(headings)), _information(fine, headings)
    a, b = coarse.a, coarse.b
    known = (part[a] == part[b]) & (np.abs(coarse.covariances).max(axis=(1, 2)) < LARGEST)
    rows = np.flatnonzero(known & (information[a, 2, 2] > 0.0) & (information[b, 2, 2] > 0.0))
    both = np.linalg.inv(np.linalg.inv(information[a[rows]]) + np.linalg.inv(information[b[rows]]))
    turn, own = _turns(headings[a[rows]]), coarse.covariances[rows]
    both = turn.transpose(0, 2, 1) @ both @ turn
    grown = own + EVEN**2 @ both @ EVEN**2
    covariances = coarse.covariances.copy()
    covariances[rows] = 0.5 * (grown + grown.transpose(0, 2, 1))
    return coarse.believed(covariances)


def _parts(fine: EdgeTable, count: int) -> Array:
    """The part (N,) that every view belongs to: from one to the other there is a way along fine edges."""
    graph = sparse.coo_matrix((np.ones(len(fine)), (fine.a, fine.b)), shape=(count, count))
    return csgraph.connected_components(graph, directed=False)[1]


def _information(fine: EdgeTable, headings: Array) -> Array:
    """Information (N, 3, 3) that each view has from its fine edges, in the world's axes."""
    roots = whitening(fine.covariances) @ _turns(headings[fine.a]).transpose(0, 2, 1)
    each = roots.transpose(0, 2, 1) @ roots
    information = np.zeros((len(headings), 3, 3))
    np.add.at(information, fine.a, each)
    np.add.at(information, fine.b, each)
    return information


def _turns(headings: Array) -> Array:
    """Headings (K,) [rad] → what turns x, y and leaves the heading (K, 3, 3)."""
    c, s, none, one = np.cos(headings), np.sin(headings), np.zeros_like(headings), np.ones_like(headings)
    return np.array([[c, -s, none], [s, c, none], [none, none, one]]).transpose(2, 0, 1)
