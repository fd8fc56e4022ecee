"""Upper bounds on the highest frequency and damping rate of a body, which limit the explicit step.

Springs and tension along the edges, in any orientation, are at most as stiff as the graph Laplacian L of their
constants. L is a sum over the triangles; each gets its share of its edges and a part m_T of the masses at its corners,
so

    highest eigenvalue of M^-1 L <= max over triangles of that of M_T^-1 L_T

which on an even mesh is three quarters of Gershgorin's bound, and never larger, because masses are divided in
proportion to stiffness. Of the three eigenvalues of a triangle with edges a, b, c opposite its corners two are not 0.
Their sum is s = sum of (the edges at a corner) / m, and their product is
q = (a b + b c + c a) (1/m1 m2 + 1/m2 m3 + 1/m3 m1).
Source: Irons and Treharne 1971, a bound theorem in eigenvalues.

A fill adds f g^ g^T, where g^ is the unit vector along M^-1/2 dV/dx. Let A be the matrix without the fill and a its
bound. Then no eigenvalue of A + f g^ g^T exceeds the larger eigenvalue of

    [ g^.A g^ + f          |A g^ - (g^.A g^) g^| ]
    [ |A g^ - (g^.A g^) g^|          a           ]

The fill moves neighbours together and L moves them apart, so this is little more than the larger of f and a.

A pressure p at rest adds p d2V/dx_i dx_j, where the second derivative is the cross-product matrix of the vector between
the two vertices opposite the edge ij, divided by 6. By Gershgorin no eigenvalue of it exceeds |p| / 3 times the length
of the edges opposite a vertex.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..base import Floats, row_parts, sums_at, sums_of_three
from ..mesh.surface import Mesh, cap_centres
from .pressure import Pressure, pressure_slope, volume_and_gradient


def of_edges(mesh: Mesh, constants: Floats, at_vertices: Floats, inverse_mass: Floats) -> float:
    """Bound the eigenvalues of M^-1 (L + D).

    Args:
        constants: (m,) of springs or dashpots along the edges, for L.
        at_vertices: (n,) for the diagonal matrix D.
        inverse_mass: (n,) [1/kg], 0 where pinned.
    """
    own = at_vertices * inverse_mass
    if not len(mesh.triangles):
        return float(own.max())
    n, corners = len(inverse_mass), mesh.triangles
    edges = np.take(mesh.triangle_springs, (1, 2, 0), axis=1)  # opposite each corner
    each = constants / np.maximum(np.bincount(edges.ravel(), minlength=len(constants)), 1)
    meets, parts = np.empty(corners.shape), list(row_parts(len(corners)))
    for part in parts:
        opposite = each[edges[part]]
        meets[part] = sums_of_three(opposite)[:, None] - opposite
    met, most = inverse_mass * sums_at(corners.ravel(), meets.ravel(), n), [own.max()]
    for part in parts:
        # 1 / m_T, where m_T = m (stiffness of the triangle at this corner) / (stiffness of all triangles at the vertex)
        inverse = met[corners[part]] / np.maximum(meets[part], 1e-30)
        s = sums_of_three(meets[part] * inverse)
        a, b, c = each[edges[part]].T
        i, j, k = inverse.T
        q = (a * b + b * c + c * a) * (i * j + j * k + k * i)
        highest = (s + np.sqrt(np.maximum(s * s - 4 * q, 0))) / 2
        a, b, c = own[corners[part]].T
        most.append((highest + np.maximum(np.maximum(a, b), c)).max())
    return float(max(most))


def of_body(
    mesh: Mesh, constants: Floats, at_vertices: Floats, inverse_mass: Floats, fill: Pressure, reserve: float = 1.0
) -> float:
    """Bound the square of the highest angular frequency [1/s2] of a body with a fill; see `of_edges`.

    Args:
        reserve: factor on the stiffness of the fill at rest.
    """
    if fill.kind and fill.rest_pressure:
        at_vertices = at_vertices + abs(fill.rest_pressure) / 3 * _edges_round(mesh)
        fill = replace(fill, rest_pressure=max(fill.rest_pressure, 0.0))  # suction shrinks a body, which stiffens it
    skin = of_edges(mesh, constants, at_vertices, inverse_mass)
    if not fill.kind:
        return skin
    volume, gradient = volume_and_gradient(fill, mesh.rest_positions.T)
    root = np.sqrt(inverse_mass)
    along = root * gradient
    square = float((along**2).sum())
    if not square > 0:
        return skin
    along /= np.sqrt(square)
    moved, (i, j) = root * along, mesh.springs.T
    pulls = (constants * (x[i] - x[j]) for x in moved)
    held = np.stack([sums_at(i, p, len(root)) - sums_at(j, p, len(root)) for p in pulls]) + at_vertices * moved
    met = float((root * held * along).sum())
    across = float(np.sqrt(((root * held - met * along) ** 2).sum()))
    whole = met + reserve * pressure_slope(fill, volume) * square
    return (whole + skin) / 2 + float(np.hypot((whole - skin) / 2, across))


def _edges_round(mesh: Mesh) -> Floats:
    """Return the length (n,) [m] of the edges opposite each vertex, in its triangles and the cones that close holes."""
    opposite = mesh.rest_lengths[np.take(mesh.triangle_springs, (1, 2, 0), axis=1)]
    corners, lengths, x = mesh.triangles.ravel(), opposite.ravel(), mesh.rest_positions
    if len(mesh.cap_edges):
        centres, _ = cap_centres(x, mesh.cap_edges, mesh.cap_loop)
        far = np.linalg.norm(x[mesh.cap_edges[:, ::-1]] - centres[mesh.cap_loop][:, None], axis=2)
        corners, lengths = np.append(corners, mesh.cap_edges), np.append(lengths, far)
    return sums_at(corners, lengths, len(x))
