"""From a projected system of coordinates (UTM and others, by EPSG number) to WGS 84."""

from __future__ import annotations

import math

from rover.report.site import Georeference, GridPosition


def georeference(position: GridPosition, bearing_deg: float) -> Georeference:
    """`bearing_deg`: of map +y from the grid's north. The bearing that comes back is from true north.

    Raises ValueError for a number that names no projected system in metres, and for a place outside of it.
    """
    # Loading its database takes a tenth of a second, which only such a mission file costs.
    from pyproj import CRS, Proj, Transformer
    from pyproj.exceptions import CRSError, ProjError

    try:
        system = CRS.from_epsg(position.epsg)
    except CRSError:
        raise ValueError(f"EPSG:{position.epsg} is not known") from None
    if not system.is_projected or any(axis.unit_name != "metre" for axis in system.axis_info):
        raise ValueError(f"EPSG:{position.epsg} ({system.name}) is no projected system in metres, such as UTM")
    outside = f"{position.easting:g}, {position.northing:g} lies outside EPSG:{position.epsg} ({system.name})"
    try:
        to_degrees = Transformer.from_crs(system, CRS.from_epsg(4326), always_xy=True)
        longitude, latitude = to_degrees.transform(position.easting, position.northing, errcheck=True)
        back = Transformer.from_crs(CRS.from_epsg(4326), system, always_xy=True).transform(longitude, latitude)
        factors = Proj(system).get_factors(longitude, latitude)
    except ProjError:
        raise ValueError(outside) from None
    area = system.area_of_use
    # Some projections fold back on themselves: a place that does not come back is not in them.
    if (
        not all(map(math.isfinite, (longitude, latitude, *back)))
        or math.dist(back, (position.easting, position.northing)) > 0.01
    ):
        raise ValueError(outside)
    if area is not None and not (area.south - 1.0 <= latitude <= area.north + 1.0):
        raise ValueError(outside)
    return Georeference(latitude, longitude, (bearing_deg + factors.meridian_convergence) % 360.0)
