// A thermal picture with the candidates that it shows.
import { h } from "./dom";
import type { Json } from "./api";
import { number } from "./dom";
import { t } from "./strings";

export class Picture {
  readonly canvas = h("canvas", { class: "thermal", role: "img", "aria-label": t("thermal_none"), width: 320, height: 240 });

  /** `source`: an address or data; candidates in pixels of the picture. */
  async show(source: string, candidates: Json[], time: number): Promise<void> {
    const image = new Image();
    image.src = source;
    await image.decode().catch(() => undefined);
    if (!image.naturalWidth) return;
    const scale = 3;
    this.canvas.width = image.naturalWidth * scale;
    this.canvas.height = image.naturalHeight * scale;
    const pen = this.canvas.getContext("2d");
    if (!pen) return;
    pen.imageSmoothingEnabled = false;
    pen.drawImage(image, 0, 0, this.canvas.width, this.canvas.height);
    pen.lineWidth = 3;
    pen.font = "bold 20px sans-serif";
    for (const { id, u, v } of candidates) {
      const [x, y] = [(u + 0.5) * scale, (v + 0.5) * scale];
      pen.strokeStyle = "#000";
      pen.beginPath(); pen.arc(x, y, 22, 0, 7); pen.stroke();
      pen.strokeStyle = pen.fillStyle = "#ffd400";
      pen.beginPath(); pen.arc(x, y, 19, 0, 7); pen.stroke();
      if (id !== undefined) pen.fillText(String(id), x + 24, y - 10);
    }
    this.canvas.setAttribute("aria-label", t("thermal_alt", { t: number(time, 1), n: candidates.length }));
  }
}
