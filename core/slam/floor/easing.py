"""Coarse measurements give way where finer ones hold the same views: wheels err alike at every turn, walls do not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from core.message import Array
from core.slam.floor.pose_graph import Edge

EVEN = np.diag([0.06, 0.06, math.radians(1.3)])  # [m], [rad] sd told by fine edges for which as much doubt is added
LARGEST = 1.0  # [m²], [rad²]: what is less certain than that says nothing that could give way


def eased(coarse: Sequence[Edge], fine: Sequence[Edge], headings: Array) -> list[Edge]:
    """Coarse edges, believed the less the more the fine ones tell of both their ends; world headings (N,) [rad].

    C + EVEN² I EVEN², I the information that both ends have from the fine edges, where a way along these leads from
    one end to the other. It goes direction by direction: along a bare corridor, where walls tell nothing, C remains.
    What is systematic in the wheels (a laser that stands aside of where the robot turns) is in every coarse edge and
    does not average out, and the coarse edges may claim millimetres: weighed by that, they would bend the fine ones.
    """
    if not fine or not coarse:
        return list(coarse)
    part, told = _parts(fine, len(headings)), _told(fine, headings)
    a, b = np.array([edge.a for edge in coarse]), np.array([edge.b for edge in coarse])
    covariances = np.array([edge.covariance for edge in coarse])
    known = (part[a] == part[b]) & (np.abs(covariances).max(axis=(1, 2)) < LARGEST)
    rows = np.flatnonzero(known & (told[a, 2, 2] > 0.0) & (told[b, 2, 2] > 0.0))
    both = np.linalg.inv(np.linalg.inv(told[a[rows]]) + np.linalg.inv(told[b[rows]]))
    turn, own = _turns(headings[a[rows]]), covariances[rows]
    both = turn.transpose(0, 2, 1) @ both @ turn
    grown = own + EVEN**2 @ both @ EVEN**2
    grown = 0.5 * (grown + grown.transpose(0, 2, 1))
    edges = list(coarse)
    for row, covariance in zip(rows.tolist(), grown, strict=True):
        edges[row] = replace(edges[row], covariance=covariance)
    return edges


def _parts(fine: Sequence[Edge], count: int) -> Array:
    """The part (N,) that every view belongs to: from one to the other there is a way along fine edges."""
    ends = ([edge.a for edge in fine], [edge.b for edge in fine])
    graph = sparse.coo_matrix((np.ones(len(fine)), ends), shape=(count, count))
    return csgraph.connected_components(graph, directed=False)[1]


def _told(fine: Sequence[Edge], headings: Array) -> Array:
    """Information (N, 3, 3) that each view has from its fine edges, in the world's axes."""
    a, b = np.array([edge.a for edge in fine]), np.array([edge.b for edge in fine])
    turn = _turns(headings[a])
    each = turn @ np.linalg.inv(np.array([edge.covariance for edge in fine])) @ turn.transpose(0, 2, 1)
    told = np.zeros((len(headings), 3, 3))
    np.add.at(told, a, each)
    np.add.at(told, b, each)
    return told


def _turns(headings: Array) -> Array:
    """Headings (K,) [rad] → what turns x, y and leaves the heading (K, 3, 3)."""
    c, s, none, one = np.cos(headings), np.sin(headings), np.zeros_like(headings), np.ones_like(headings)
    return np.array([[c, -s, none], [s, c, none], [none, none, one]]).transpose(2, 0, 1)
