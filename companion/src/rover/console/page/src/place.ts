// Between WGS 84 and metres of the map: the same tangent plane as the report's GeoJSON (rover.report.geojson).
import type { Json } from "./api";

const SEMI_MAJOR_AXIS_M = 6_378_137.0;
const ECCENTRICITY_SQUARED = 6.694_379_990_14e-3;
const RADIANS = Math.PI / 180;

export interface Origin { latitude: number; longitude: number; bearing_deg: number }

export function originOf(document: Json): Origin | null {
  const [latitude, longitude] = document.site?.origin ?? [];
  if (typeof latitude !== "number" || typeof longitude !== "number") return null;
  return { latitude, longitude, bearing_deg: document.site.bearing_deg ?? 0 };
}

/** Longitude and latitude to x, y of the map. */
export function toMap(origin: Origin, [longitude, latitude]: number[]): [number, number] {
  const squeeze = 1 - ECCENTRICITY_SQUARED * Math.sin(origin.latitude * RADIANS) ** 2;
  const along = (SEMI_MAJOR_AXIS_M * (1 - ECCENTRICITY_SQUARED)) / squeeze ** 1.5;
  const across = SEMI_MAJOR_AXIS_M / Math.sqrt(squeeze);
  const north = ((latitude ?? 0) - origin.latitude) * RADIANS * along;
  const east = ((longitude ?? 0) - origin.longitude) * RADIANS * across * Math.cos(origin.latitude * RADIANS);
  const [c, s] = [Math.cos(origin.bearing_deg * RADIANS), Math.sin(origin.bearing_deg * RADIANS)];
  return [c * east - s * north, s * east + c * north];
}
