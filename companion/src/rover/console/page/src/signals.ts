// Signals over the mission's time.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { h } from "./dom";
import { t } from "./strings";

const WIDTH = 560;

export class Signals {
  readonly element = h("div", { class: "signals" });
  private readonly plots: [uPlot, string][] = [];
  private readonly keep: number;
  private readonly data = new Map<string, [number[], number[]]>();

  constructor(series: [name: string, unit: string][], keep = 3000) {
    this.keep = keep;
    for (const [name, unit] of series) {
      const holder = h("div", { role: "img", "aria-label": `${t("signals")}: ${name}` });
      const plot = new uPlot({
        width: WIDTH, height: 130, title: `${name}, ${unit}`, legend: { show: false }, cursor: { show: false },
        scales: { x: { time: false } },
        axes: [{ stroke: "#1b1b1b", grid: { stroke: "#d0d0d0" } }, { stroke: "#1b1b1b", grid: { stroke: "#d0d0d0" }, size: 60 }],
        series: [{}, { stroke: "#0b3d91", width: 2 }],
      }, [[], []], holder);
      this.plots.push([plot, name]);
      this.data.set(name, [[], []]);
      this.element.append(holder);
    }
    new ResizeObserver(() => {
      const width = Math.max(200, Math.min(this.element.clientWidth, 900));
      for (const [plot] of this.plots) if (plot.width !== width) plot.setSize({ width, height: 130 });
    }).observe(this.element);
  }

  set(name: string, points: number[][]): void {
    this.data.set(name, [points.map((p) => p[0] ?? 0), points.map((p) => p[1] ?? 0)]);
    this.draw(name);
  }

  add(name: string, time: number, value: unknown): void {
    const [times, values] = this.data.get(name) ?? [[], []];
    if (typeof value !== "number") return;
    if (times.length && time <= (times[times.length - 1] ?? 0)) return;
    times.push(time);
    values.push(value);
    if (times.length > this.keep) { times.shift(); values.shift(); }
    this.draw(name);
  }

  clear(): void {
    for (const [, name] of this.plots) this.set(name, []);
  }

  private draw(name: string): void {
    const plot = this.plots.find(([, each]) => each === name)?.[0];
    plot?.setData(this.data.get(name) ?? [[], []]);
  }
}
