// The map: OpenLayers over a plane of metres, without any tiles.
import Feature from "ol/Feature";
import OlMap from "ol/Map";
import View from "ol/View";
import { MousePosition, ScaleLine } from "ol/control";
import { defaults as defaultControls } from "ol/control/defaults";
import { Circle, LineString, Point, Polygon, type Geometry } from "ol/geom";
import ImageLayer from "ol/layer/Image";
import VectorLayer from "ol/layer/Vector";
import { Projection } from "ol/proj";
import ImageStatic from "ol/source/ImageStatic";
import VectorSource from "ol/source/Vector";
import { Circle as Dot, Fill, RegularShape, Stroke, Style, Text } from "ol/style";
import "ol/ol.css";
import { h } from "./dom";
import type { Json } from "./api";
import { t, word, type Key } from "./strings";

export const METRES = new Projection({ code: "rover:map", units: "m", extent: [-200, -200, 300, 300] });

const stroke = (color: string, width = 2, lineDash?: number[]) => new Stroke({ color, width, lineDash });
const label = (text: string) => new Text({
  text, font: "bold 14px sans-serif", offsetY: -16, fill: new Fill({ color: "#fff" }),
  backgroundFill: new Fill({ color: "#5c0a08" }), padding: [2, 4, 1, 4],
});

const STYLES: Record<string, (feature: Feature) => Style> = {
  area: () => new Style({ stroke: stroke("#0b3d91", 3), fill: new Fill({ color: "#0b3d9112" }) }),
  exclude: () => new Style({ stroke: stroke("#7a1fa2", 2, [8, 5]), fill: new Fill({ color: "#7a1fa233" }) }),
  obstacle: () => new Style({ stroke: stroke("#403528"), fill: new Fill({ color: "#403528aa" }) }),
  goal: (f) => new Style({
    image: new RegularShape({ points: 4, radius: 9, angle: Math.PI / 4, stroke: stroke("#fff"), fill: new Fill({ color: "#14613a" }) }),
    text: f.get("text") && label(f.get("text")),
  }),
  marker: () => new Style({ image: new RegularShape({ points: 4, radius: 8, stroke: stroke("#000"), fill: new Fill({ color: "#ffd400" }) }) }),
  launch: (f) => new Style({
    image: new RegularShape({ points: 3, radius: 12, rotation: Math.PI / 2 - (f.get("heading") ?? 0), stroke: stroke("#fff"), fill: new Fill({ color: "#9c4a00" }) }),
  }),
  rover: (f) => new Style({
    image: new RegularShape({ points: 3, radius: 15, rotation: Math.PI / 2 - (f.get("heading") ?? 0), rotateWithView: true, stroke: stroke("#fff", 3), fill: new Fill({ color: "#000" }) }),
  }),
  sigma: () => new Style({ stroke: stroke("#000", 1, [3, 3]) }),
  track: () => new Style({ stroke: stroke("#ffffff", 5) }),
  track_core: () => new Style({ stroke: stroke("#0b3d91", 2) }),
  plan: () => new Style({ stroke: stroke("#c2185b", 3, [10, 6]) }),
  zone: (f) => new Style({
    stroke: stroke("#b3261e", 3, f.get("rejected") ? [4, 4] : undefined), fill: new Fill({ color: "#b3261e33" }),
    text: f.get("text") && label(f.get("text")),
  }),
  mark: (f) => new Style({
    image: new RegularShape({ points: 4, radius: 9, radius2: 0, stroke: stroke("#5c0a08", 3) }), text: f.get("text") && label(f.get("text")),
  }),
  other: () => new Style({ image: new Dot({ radius: 9, stroke: stroke("#00695c", 3) }) }),
};

type Raster = "temperature" | "seen" | "obstacles";

/** One map on the page. Layers have names of the catalogue, layer_NAME. */
export class Chart {
  readonly element: HTMLDivElement;
  readonly map: OlMap;
  private readonly vectors = new Map<string, VectorSource>();
  private readonly rasters = new Map<string, ImageLayer<ImageStatic>>();
  private readonly switches = h("fieldset", { class: "switches" }, h("legend", {}, t("layers")));
  private readonly canvas = h("div", { class: "map", tabindex: 0, role: "application", "aria-label": t("map") });
  private fitted = "";

  constructor(rasters: Raster[], vectors: string[]) {
    this.map = new OlMap({
      target: this.canvas,
      controls: defaultControls({ attribution: false, rotate: false }).extend([new ScaleLine(), new MousePosition({ coordinateFormat: (at) => (at ? `${at[0]!.toFixed(3)}, ${at[1]!.toFixed(3)} m` : "") })]),
      view: new View({ projection: METRES, center: [2, 2], resolution: 0.01, minResolution: 0.0005, maxResolution: 1 }),
    });
    for (const name of rasters) {
      const layer = new ImageLayer<ImageStatic>({ opacity: 1 });
      this.rasters.set(name, layer);
      this.map.addLayer(layer);
      this.addSwitch(name, (shown) => layer.setVisible(shown));
    }
    for (const name of vectors) {
      const source = new VectorSource();
      const layer = new VectorLayer({ source, style: (f) => STYLES[f.get("style")]?.(f as Feature) });
      this.vectors.set(name, source);
      this.map.addLayer(layer);
      this.addSwitch(name, (shown) => layer.setVisible(shown));
    }
    this.element = h("div", { class: "chart" }, this.canvas, this.switches);
  }

  private addSwitch(name: string, show: (shown: boolean) => void): void {
    const box = h("input", { type: "checkbox", checked: true, change: () => show(box.checked) });
    this.switches.append(h("label", {}, box, word(`layer_${name}`)));
  }

  source(name: string): VectorSource {
    const source = this.vectors.get(name);
    if (!source) throw new Error(name);
    return source;
  }

  /** Puts features in place of what a layer showed. */
  put(name: string, features: Feature[]): void {
    const source = this.source(name);
    source.clear(true);
    source.addFeatures(features);
  }

  raster(name: Raster, png: string, width: number, height: number): void {
    this.rasters.get(name)?.setSource(new ImageStatic({
      url: `data:image/png;base64,${png}`, imageExtent: [0, 0, width, height], projection: METRES, interpolate: false,
    }));
  }

  /** Shows all of an area, once for each `name`. */
  fit(name: string, extent: number[]): void {
    if (this.fitted === name) return;
    this.map.updateSize();
    if ((this.map.getSize()?.[0] ?? 0) === 0) return;
    this.fitted = name;
    this.map.getView().fit(extent, { padding: [30, 30, 50, 30] });
  }

  shown(): void {
    requestAnimationFrame(() => this.map.updateSize());
  }
}

export function feature(style: string, geometry: Geometry, values: Json = {}): Feature {
  return new Feature({ geometry, style, ...values });
}

export const disc = (x: number, y: number, r: number) => new Circle([x, y], r);
export const dot = (x: number, y: number) => new Point([x, y]);
export const line = (points: number[][]) => new LineString(points);
export const outline = (points: number[][]) => new Polygon([[...points, points[0] ?? [0, 0]]]);

/** The way driven, legible on any ground. */
export function trackFeatures(points: number[][]): Feature[] {
  return points.length > 1 ? [feature("track", line(points)), feature("track_core", line(points))] : [];
}

/** What a mission file says, as features. */
export function missionFeatures(mission: Json): Feature[] {
  const area = mission.area;
  const corners = area.polygon.length ? area.polygon
    : [[0, 0], [area.width_m, 0], [area.width_m, area.height_m], [0, area.height_m]];
  return [
    feature("area", outline(corners)),
    ...area.exclude.map((hole: number[][]) => feature("exclude", outline(hole))),
    ...area.obstacles.map(([x, y, r]: number[]) => feature("obstacle", disc(x ?? 0, y ?? 0, r ?? 0))),
    ...mission.goals.map(([x, y]: number[], i: number) => feature("goal", dot(x ?? 0, y ?? 0), { text: `G${i + 1}` })),
    feature("launch", dot(mission.launch.x, mission.launch.y), { heading: mission.launch.heading }),
  ];
}

export type { Key };
