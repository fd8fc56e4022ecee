"""The elements of a solid of rubber about an axis: stiffness, stress and volume, by scikit-fem.

W = mu/2 (I1 - 3 - 2 ln J) + lambda/2 (J - 1)^2 (neo-Hookean), of which Hooke's law is the stiffness at rest. Quadratic
elements of displacement alone: at Poisson's ratio 0.49 they do not lock, and where Taylor and Hood's, with a pressure
beside, buckle in compression though the solid does not, they are stable.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, LinearForm, MeshQuad

from core.base import Floats

Array = Any  # arrays and fields of scikit-fem, which has no types


class Solid:
    """A body, its elements and what the tip can touch of it; Young's modulus is 1 Pa."""

    def __init__(self, mesh: MeshQuad, poisson: float, touched: float) -> None:
        self.mesh = mesh
        self.shear, self.lame = 1 / (2 + 2 * poisson), poisson / ((1 + poisson) * (1 - 2 * poisson))
        self.u = Basis(mesh, ElementVector(ElementQuad2()), intorder=4)
        floor, at = mesh.p[1].min(), self.u.doflocs
        radial = np.zeros(self.u.N, dtype=bool)
        radial[np.concatenate([self.u.nodal_dofs[0], self.u.facet_dofs[0], self.u.interior_dofs[0]])] = True
        self.free = np.flatnonzero((at[1] > floor + 1e-9) & ((at[0] > 1e-9) | ~radial))
        outer = mesh.boundary_facets()
        middle = mesh.p[:, mesh.facets[:, outer]].mean(axis=1)
        skin = outer[(middle[0] > 1e-9) & (middle[1] > floor + 1e-9)]
        vertices = np.unique(mesh.facets[:, skin])
        unknowns = np.concatenate([self.u.nodal_dofs[:, vertices], self.u.facet_dofs[:, skin]], axis=1)
        along = np.lexsort((at[0, unknowns[0]], -at[1, unknowns[0]]))  # down the skin; on a flat face outwards
        self.nodes = unknowns[:, along]
        self.rest = at[:, self.nodes[0]]
        self.touch = np.flatnonzero((self.rest[0] < touched) & (self.rest[1] > -touched))

    def stiffness(self, u: Floats) -> csr_matrix:
        """Return the tangent stiffness at a displacement (n,) [m], over 2 pi.

        Raises:
            FloatingPointError: an element is turned inside out.
        """
        now = self.u.interpolate(u)
        if np.min(deformation(now, self.u.global_coordinates()[0])[2]) <= 0:
            raise FloatingPointError
        return BilinearForm(self._stiffness).assemble(self.u, now=now)

    def stress(self, u: Floats) -> Floats:
        """Return the forces (n,) that hold a displacement (n,) [m], over 2 pi."""
        return LinearForm(self._stress).assemble(self.u, now=self.u.interpolate(u))

    def _stiffness(self, u: Array, v: Array, w: Array) -> Array:
        inverse, hoop, volume = deformation(w["now"], w.x[0])
        a, b, product = relative(u, inverse, hoop, w), relative(v, inverse, hoop, w), plain(u, v, w)
        turned = np.einsum("ij...,ji...->...", a[0], b[0]) + a[2] * b[2]
        pressure = self.lame * (volume - 1)
        both = volume * (pressure + self.lame * volume) * a[1] * b[1]
        return (self.shear * (product + turned) + both - pressure * volume * turned) * w.x[0]

    def _stress(self, v: Array, w: Array) -> Array:
        inverse, hoop, volume = deformation(w["now"], w.x[0])
        opened = v.grad[0, 0] + v.grad[1, 1] + v[0] / w.x[0]
        swell = relative(v, inverse, hoop, w)[1]
        shear = self.shear * (plain(w["now"], v, w) + opened - swell)
        return (shear + self.lame * (volume - 1) * volume * swell) * w.x[0]

    def swollen(self, state: Floats) -> float:
        """Return the change of the volume over the volume at rest."""
        now, r = self.u.interpolate(state[: self.u.N]), self.u.global_coordinates()[0]
        return float(np.sum((deformation(now, r)[2] - 1) * r * self.u.dx) / np.sum(r * self.u.dx))


def deformation(now: Array, r: Array) -> tuple[Array, Array, Array]:
    """Return the inverse of the deformation gradient in the section (2, 2), the hoop stretch, the volume ratio."""
    a, b, c, d = 1 + now.grad[0, 0], now.grad[0, 1], now.grad[1, 0], 1 + now.grad[1, 1]
    area, hoop = a * d - b * c, 1 + np.asarray(now)[0] / r
    return np.array([[d, -b], [-c, a]]) / area, hoop, area * hoop


def relative(u: Array, inverse: Array, hoop: Array, w: Array) -> tuple[Array, Array, Array]:
    """Return grad u times the inverse deformation gradient: in the section (2, 2), its trace with hoop, the hoop."""
    section = np.einsum("ij...,jk...->ik...", u.grad, inverse)
    around = u[0] / w.x[0] / hoop
    return section, section[0, 0] + section[1, 1] + around, around


def plain(u: Array, v: Array, w: Array) -> Array:
    """Return grad u : grad v."""
    return np.einsum("ij...,ij...->...", u.grad, v.grad) + u[0] * v[0] / w.x[0] ** 2
