// Shapes of a GeoJSON or KML file, in metres of the map. The browser's own parsers read them; nothing in them is run.
import GeoJSON from "ol/format/GeoJSON";
import KML from "ol/format/KML";
import type Feature from "ol/Feature";
import { LineString, MultiPolygon, Point, Polygon } from "ol/geom";
import type { Json } from "./api";
import { originOf, toMap, type Origin } from "./place";

export interface Shape { kind: string; polygon?: number[][]; point?: number[] }
export interface Imported { shapes: Shape[]; origin: Origin | null }

const MARGIN_M = 1;

/** The file's shapes; `origin` is what the mission needs to hold when its own has none. Throws what is wrong. */
export function readShapes(name: string, text: string, document: Json): Imported {
  const kml = /\.kml$/i.test(name);
  const local = !kml && isLocal(JSON.parse(text));
  const features = (kml ? new KML({ extractStyles: false }) : new GeoJSON())
    .readFeatures(text, { dataProjection: "EPSG:4326", featureProjection: "EPSG:4326" });
  const raw = features.flatMap(shapesOf);
  if (local || raw.length === 0) return { shapes: raw, origin: originOf(document) };
  const all = raw.flatMap((shape) => shape.polygon ?? (shape.point ? [shape.point] : []));
  const origin = originOf(document) ?? southWest(all);
  const place = (point: number[]) => toMap(origin, point).map((value) => Math.round(value * 1000) / 1000);
  const shapes = raw.map((shape) => ({ ...shape, polygon: shape.polygon?.map(place), point: shape.point && place(shape.point) }));
  return { shapes, origin };
}

function isLocal(content: Json): boolean {
  return content["rover:frame"] !== undefined;
}

/** An origin a metre outside of everything, so that all of it lies at positive x and y. */
function southWest(points: number[][]): Origin {
  const longitude = Math.min(...points.map((point) => point[0] ?? 0));
  const latitude = Math.min(...points.map((point) => point[1] ?? 0));
  const metre = 1 / 111_320;
  return {
    latitude: Number((latitude - MARGIN_M * metre).toFixed(9)),
    longitude: Number((longitude - (MARGIN_M * metre) / Math.cos((latitude * Math.PI) / 180)).toFixed(9)),
    bearing_deg: 0,
  };
}

function shapesOf(feature: Feature): Shape[] {
  const kind = String(feature.get("kind") ?? feature.get("name") ?? "").toLowerCase();
  const geometry = feature.getGeometry();
  const open = (ring: number[][]) => ring.slice(0, -1).map((point) => point.slice(0, 2));
  const outlines = (polygon: Polygon): Shape[] => polygon.getCoordinates().map((ring, index) => ({
    kind: index > 0 ? "exclude" : kind, polygon: open(ring),
  }));
  if (geometry instanceof Polygon) return outlines(geometry);
  if (geometry instanceof MultiPolygon) return geometry.getPolygons().flatMap(outlines);
  if (geometry instanceof Point) return [{ kind, point: geometry.getCoordinates().slice(0, 2) }];
  if (geometry instanceof LineString && kind.includes("area")) {
    return [{ kind, polygon: geometry.getCoordinates().map((point) => point.slice(0, 2)) }];
  }
  return [];
}
