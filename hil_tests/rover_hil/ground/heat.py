"""Heat conduction in the ground over a day, with or without something buried in it.

Solves ρc ∂T/∂t = ∇·(k∇T) on an axisymmetric (r, z) grid under the surface balance
−k ∂T/∂z = (1−α)S(t) + h(T_air − T) + εσ(T_sky⁴ − T⁴), for a batch of cases at once.

Method: finite volumes with harmonic face conductances; Douglas alternating-direction implicit steps. The
radiation is linearised at a fixed temperature inside the matrices, its remainder enters one step late, so the
matrices are constant and their inverses are formed once. Everything is float64 and free of randomness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rover_hil.ground.soils import CLEAR_DAY, DAY_S, STEFAN_BOLTZMANN, Material, Weather

STEPS_PER_DAY = 288
SPIN_UP_DAYS = 3


@dataclass(frozen=True)
class Inclusion:
    """A cylinder in the soil, its axis vertical: metres; `depth` is the soil above its top.

    With `depth` 0 its top is the surface over its radius and has its own albedo; `exposure` scales convection
    there, because a body that stands proud also loses heat through its side. `radius` may be inf: a layer.
    """

    material: Material
    radius: float
    thickness: float
    depth: float
    albedo: float | None = None
    exposure: float = 1.0


@dataclass(frozen=True)
class Case:
    """One column of ground to simulate; `sunlight` scales S(t): 1 in the open, less in the shade."""

    soil: Material
    inclusion: Inclusion | None = None
    sunlight: float = 1.0


@dataclass(frozen=True)
class SurfaceHistory:
    """Surface temperatures of the last simulated day.

    `radius` (nr,) cell centres in m; `hour` (nt,) local solar time; `temperature` (cases, nr, nt) in K.
    """

    radius: NDArray[np.float64]
    hour: NDArray[np.float64]
    temperature: NDArray[np.float64]

    def at(self, hour: float) -> NDArray[np.float64]:
        """Surface temperature (cases, nr) at `hour`, linear in time, periodic over the day."""
        steps = self.hour.size
        position = (hour - self.hour[0]) / 24.0 * steps
        low = int(np.floor(position))
        part = position - low
        first, second = self.temperature[..., low % steps], self.temperature[..., (low + 1) % steps]
        now: NDArray[np.float64] = (1 - part) * first + part * second
        return now


def _widths(fine: float, until: float, growth: float, end: float) -> NDArray[np.float64]:
    """Cell widths: `fine` up to `until`, then growing geometrically up to about `end`."""
    widths = [fine] * round(until / fine)
    while sum(widths) < end:
        widths.append(widths[-1] * growth)
    return np.array(widths)


R_WIDTHS = _widths(fine=0.0055, until=0.077, growth=1.30, end=0.40)
Z_WIDTHS = np.concatenate([np.full(4, 0.005), _widths(fine=0.01, until=0.14, growth=1.35, end=0.65)])


def _edges(widths: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([[0.0], np.cumsum(widths)])


def _overlap(edges: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Share of each cell that lies in [low, high]."""
    covered = np.clip(np.minimum(edges[1:], high) - np.maximum(edges[:-1], low), 0.0, None)
    share: NDArray[np.float64] = covered / np.diff(edges)
    return share


def _fill(case: Case, of: str) -> NDArray[np.float64]:
    """One material property per cell, (nr, nz): mixed by volume where a cell is cut."""
    outside = float(getattr(case.soil, of))
    if case.inclusion is None:
        return np.full((R_WIDTHS.size, Z_WIDTHS.size), outside)
    body = case.inclusion
    share = np.outer(
        _overlap(_edges(R_WIDTHS), 0.0, body.radius),
        _overlap(_edges(Z_WIDTHS), body.depth, body.depth + body.thickness),
    )
    return outside + share * (float(getattr(body.material, of)) - outside)


def _laplacian(conductance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tridiagonal exchange matrices (..., n, n) from face conductances (..., n-1); ends insulated."""
    n = conductance.shape[-1] + 1
    matrix = np.zeros((*conductance.shape[:-1], n, n))
    i = np.arange(n - 1)
    matrix[..., i, i] -= conductance
    matrix[..., i, i + 1] += conductance
    matrix[..., i + 1, i + 1] -= conductance
    matrix[..., i + 1, i] += conductance
    return matrix


def _mean_temperature(weather: Weather, albedo: float, emissivity: float, sunlight: float) -> float:
    """Temperature at which the daily mean of the surface balance is zero, K: where the deep soil settles."""
    hours = np.arange(96) * 0.25
    air, sky = weather.air(hours), weather.sky(hours)
    gain = np.mean((1 - albedo) * sunlight * weather.irradiance(hours) + weather.convection * air)
    gain += np.mean(emissivity * STEFAN_BOLTZMANN * sky**4)
    temperature = float(weather.air_mean)
    for _ in range(20):  # Newton; converges in four or five
        loss = weather.convection * temperature + emissivity * STEFAN_BOLTZMANN * temperature**4
        slope = weather.convection + 4 * emissivity * STEFAN_BOLTZMANN * temperature**3
        temperature += float((gain - loss) / slope)
    return temperature


def simulate(
    cases: Sequence[Case],
    weather: Weather = CLEAR_DAY,
    spin_up_days: int = SPIN_UP_DAYS,
    steps_per_day: int = STEPS_PER_DAY,
) -> SurfaceHistory:
    """Surface temperature of every case over one day after `spin_up_days` of the same weather."""
    dt = DAY_S / steps_per_day
    r_edges = _edges(R_WIDTHS)
    radius = 0.5 * (r_edges[1:] + r_edges[:-1])

    k = np.stack([_fill(case, "conductivity") for case in cases])  # (cases, nr, nz)
    capacity = np.stack([_fill(case, "heat_capacity") for case in cases])
    emissivity = np.array([case.soil.emissivity for case in cases])[:, None]
    top = np.stack(
        [_fill_top(case) for case in cases]
    )  # (cases, nr, 2): absorbed share of S, convection scale
    absorbed, convection = top[..., 0], weather.convection * top[..., 1]

    # Conductances between cell centres, per unit of cell volume: z first, then r with its 2πr faces.
    half_z = 0.5 * Z_WIDTHS / k
    z_face = 1.0 / (half_z[..., :-1] + half_z[..., 1:])
    a_z = _laplacian(z_face) / (capacity * Z_WIDTHS)[..., None]
    half_r = 0.5 * R_WIDTHS[:, None] / k
    r_face = r_edges[1:-1, None] / (half_r[:, :-1] + half_r[:, 1:])
    a_r = _laplacian(np.swapaxes(r_face, 1, 2))  # (cases, nz, nr, nr)
    a_r /= np.swapaxes(capacity * (radius * R_WIDTHS)[:, None], 1, 2)[..., None]

    # Surface: T_s = (G T_1 + F)/(G + H), flux into the top cell G/(G+H) (F − H T_1).
    fixed = np.array(
        [_mean_temperature(weather, c.soil.albedo, c.soil.emissivity, c.sunlight) for c in cases]
    )[:, None]
    slope = 4 * emissivity * STEFAN_BOLTZMANN * fixed**3
    conductance = 1.0 / half_z[..., 0]
    loss = convection + slope
    to_top = conductance / (conductance + loss) / (capacity[..., 0] * Z_WIDTHS[0])
    a_z[..., 0, 0] -= to_top * loss

    solve_z = np.linalg.inv(np.eye(Z_WIDTHS.size) - dt * a_z)
    solve_r = np.linalg.inv(np.eye(R_WIDTHS.size) - dt * a_r)
    step_r = dt * a_r

    hours = (np.arange(steps_per_day) + 1) * 24.0 / steps_per_day
    sun, air, sky = weather.irradiance(hours), weather.air(hours), weather.sky(hours)
    # The part of F that does not depend on the state, (cases, nr, nt).
    forcing = absorbed[..., None] * sun + convection[..., None] * air
    forcing += (emissivity * STEFAN_BOLTZMANN)[..., None] * sky**4

    temperature = np.broadcast_to(fixed[..., None], k.shape).copy()
    surface = np.broadcast_to(fixed, k.shape[:2]).copy()
    history = np.empty((len(cases), R_WIDTHS.size, steps_per_day))
    for step in range((spin_up_days + 1) * steps_per_day):
        now = step % steps_per_day
        radiated = emissivity * STEFAN_BOLTZMANN * surface**4
        f = forcing[..., now] - radiated + slope * surface
        across = np.swapaxes(step_r @ np.swapaxes(temperature, 1, 2)[..., None], 1, 2)[..., 0]
        right = temperature + across
        right[..., 0] += dt * to_top * f
        half_way = (solve_z @ right[..., None])[..., 0]
        temperature = np.swapaxes((solve_r @ np.swapaxes(half_way - across, 1, 2)[..., None])[..., 0], 1, 2)
        surface = (conductance * temperature[..., 0] + f) / (conductance + loss)
        history[..., now] = surface
    return SurfaceHistory(radius, hours, history)


def _fill_top(case: Case) -> NDArray[np.float64]:
    """Absorbed share of S and scale of convection per radial cell, (nr, 2)."""
    share = np.zeros(R_WIDTHS.size)
    albedo, exposure = case.soil.albedo, 1.0
    body = case.inclusion
    if body is not None and body.depth == 0.0:
        share = _overlap(_edges(R_WIDTHS), 0.0, body.radius)
        albedo, exposure = (body.material.albedo if body.albedo is None else body.albedo), body.exposure
    reflected = case.soil.albedo + share * (albedo - case.soil.albedo)
    return np.stack([case.sunlight * (1 - reflected), 1 + share * (exposure - 1)], axis=-1)
