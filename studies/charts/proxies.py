"""The chart of proxies: what they miss of the shape of a dent, by their edges, and what the panel says they miss."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.base import DimpleError
from core.body.model import Model
from core.reduction.binding import carry
from core.reduction.proxy import build_proxy, mean_spacing, most_of
from core.reduction.proxy_rule import surface_error
from studies.body.presses import choose_presses, dent_error, pressed
from studies.files import new_figure, read_csv, save_picture, write_csv
from studies.meshes import bodies

PRESSES, SEED = 24, 11  # of a body, and of their places
FEWEST, GROWTH = 100, 2**0.5  # vertices of the smallest proxy, and from one to the next
KEPT = 0.98  # of the presses
FINEST, COARSEST = 0.3, 1.2  # edges over the fingertip's radius


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A proxy of a body.

    body: its name.
    vertices: simulated vertices.
    share: edges of the proxy over the fingertip's radius.
    spread: of a dent, over the fingertip's radius.
    error: of the surface that all presses but one in 50 stay below, over the fingertip's radius.
    """

    body: str
    vertices: int
    share: float
    spread: float
    error: float


def rows(body: bodies.BodyCase, fine: int = bodies.FINE, *, presses: int = PRESSES) -> Iterator[Row]:
    """Yield what proxies of growing size miss of a body that is pressed without a pressure: dents are from rest."""
    model, radius = bodies.build(body, fine), body.radius
    chosen = choose_presses(model, radius, presses, seed=SEED)
    wanted = [pressed(_limp(model), press).T for press in chosen]
    count = int(np.log(most_of(model) / FEWEST) / np.log(GROWTH)) + 1
    for vertices in (round(FEWEST * GROWTH**k) for k in range(count)):
        share = mean_spacing(model.mesh, vertices) / radius
        if not FINEST <= share <= COARSEST:
            continue
        try:
            proxy = build_proxy(model, vertices)
        except DimpleError:
            continue
        ends = [carry(proxy.binding, pressed(_limp(proxy.model), press)) for press in chosen]
        errors = [dent_error(model.mesh, end, goal) for end, goal in zip(ends, wanted, strict=True)]
        yield Row(
            body=body.name, vertices=len(proxy.seeds), share=share, spread=spread_of(model) / radius,
            error=float(np.quantile(errors, KEPT)) / radius,
        )  # fmt: skip


def spread_of(model: Model) -> float:
    """Return how far a dent reaches beyond a fingertip [m]: the root of tension over stiffness, in the mean."""
    # the sum of w l^2 over edges is twice the area, as the surface's own coordinates have the gradient 1
    tension = float((model.matching.tension * model.mesh.rest_lengths**2).sum()) / 2
    return float(np.sqrt(max(tension, 0.0) / max(float(model.matching.k1.sum()), 1e-30)))


def _limp(model: Model) -> Model:
    return replace(model, pressure=replace(model.pressure, rest_pressure=0.0))


def measure(out: Path, quick: bool) -> None:
    """Write proxies.csv."""
    cases = bodies.BODIES[2:3] if quick else bodies.BODIES
    fine, presses = (12, 4) if quick else (bodies.FINE, PRESSES)
    write_csv(
        out / "proxies.csv",
        ("body", "vertices", "spacing_over_radius", "spread_over_radius", "error_over_radius"),
        ((r.body, r.vertices, f"{r.share:.4g}", f"{r.spread:.4g}", f"{r.error:.4g}")
         for body in cases for r in rows(body, fine, presses=presses)),
    )  # fmt: skip


def draw(out: Path) -> None:
    """Draw the error of each proxy, and the one that the panel states."""
    table = read_csv(out / "proxies.csv")
    share, error = (np.array([float(r[f"{name}_over_radius"]) for r in table]) for name in ("spacing", "error"))
    figure = new_figure(7.5, 5)
    axes = figure.subplots()
    axes.loglog(share, 100 * error, "o", ms=4, alpha=0.6, label=f"measured: {len({r['body'] for r in table})} bodies")
    stated = [100 * surface_error(each, 1.0) for each in (FINEST, COARSEST)]
    axes.loglog((FINEST, COARSEST), stated, "k-", label="stated in the panel: (h / R)\u00b2 / 8")
    axes.set(
        title="A dent on a proxy is as exact as the panel says",
        xlabel="edges h of the proxy over radius R of the fingertip",
        ylabel="error of the dent in 49 of 50 presses\n[% of the fingertip's radius]",
    )  # fmt: skip
    axes.set_xticks(ticks := (0.3, 0.4, 0.6, 0.8, 1.0, 1.2), map(str, ticks))
    axes.set_yticks(ticks := (0.5, 1, 2, 5, 10, 20), map(str, ticks))
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    save_picture(figure, out / "proxies.png")
