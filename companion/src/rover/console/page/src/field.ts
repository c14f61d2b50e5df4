// What the map shows of a run, live and in replay alike.
import type Feature from "ol/Feature";
import type { Json } from "./api";
import { disc, dot, feature, line, trackFeatures, type Chart } from "./chart";

export const VECTORS = ["plan_file", "zones", "track", "plan", "goals", "sigma"];

/** Verdict of each judged place, the last one counting, and the marks. */
export function judged(judgements: Json[]): { verdicts: Map<number, Json>; marks: Json[] } {
  const verdicts = new Map<number, Json>();
  for (const each of judgements) if (each.place !== undefined) verdicts.set(each.place, each);
  return { verdicts, marks: judgements.filter((each) => each.verdict === "marked") };
}

export function zoneFeatures(places: Json[], zones: Json[], judgements: Json[]): Feature[] {
  const { verdicts, marks } = judged(judgements);
  const known = new Map(places.map((place) => [place.id, place]));
  return [
    ...zones.map((zone) => {
      const place = known.get(zone.id);
      const said = verdicts.get(zone.id)?.verdict;
      const text = place ? `${zone.id}${said === "rejected" ? " ✗" : said === "confirmed" ? " !" : ""}` : undefined;
      return feature("zone", disc(zone.x, zone.y, zone.r), { text, rejected: said === "rejected" });
    }),
    ...marks.map((mark) => feature("mark", dot(mark.x, mark.y), { text: mark.note || undefined })),
  ];
}

export function showRover(chart: Chart, x: number, y: number, heading: number, sigma: number): void {
  const shown = [feature("rover", dot(x, y), { heading })];
  if (Number.isFinite(sigma)) shown.push(feature("sigma", disc(x, y, Math.max(2 * sigma, 0.001))));
  chart.put("sigma", shown);
}

export function showTrack(chart: Chart, points: number[][]): void {
  chart.put("track", trackFeatures(points));
}

export function showPlan(chart: Chart, points: number[][]): void {
  chart.put("plan", points.length > 1 ? [feature("plan", line(points))] : []);
}

export function showGoals(chart: Chart, goals: Json[]): void {
  chart.put("goals", goals.map((goal) => feature("goal", dot(goal.x, goal.y), { text: goal.id })));
}
