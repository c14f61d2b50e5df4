// The emergency stop: in reach on every page, over the connection that is open already; the slower way if that is not.
import { post, type Json } from "./api";
import { button, h } from "./dom";
import { live, mayOperate, now, onChange } from "./shared";
import { t } from "./strings";

const ANSWER_WITHIN_MS = 400;

const told = h("p", { role: "alert", class: "stop-told" });
const stop = button(t("emergency"), press, { class: "emergency", accesskey: "e" });
export const stopBar = h("div", { class: "stop-bar" }, told, stop);

let pressed = 0;
let pending = "";

function press(): void {
  const run = now.running;
  if (!run) { told.textContent = t("emergency_none"); return; }
  pressed = performance.now();
  pending = `${Date.now()}-${Math.random()}`;
  const ref = pending;
  const sent = live.say({ op: "emergency", ref });
  told.textContent = t("emergency_sent");
  if (!sent) byRequest(run, ref);
  else setTimeout(() => pending === ref && byRequest(run, ref), ANSWER_WITHIN_MS);
}

function byRequest(run: string, ref: string): void {
  post(`runs/${encodeURIComponent(run)}/tell`, { op: "emergency" })
    .then((answer) => finish(ref, answer), (error: Error) => finish(ref, { ok: false, error: error.message }));
}

function finish(ref: string, answer: Json): void {
  if (ref !== pending) return;
  pending = "";
  const ms = Math.round(performance.now() - pressed);
  stop.dataset.ms = String(ms);
  told.textContent = answer.ok
    ? t("emergency_done", { ms })
    : t("emergency_failed", { why: answer.error });
}

live.on("stopped", (answer) => finish(answer.ref, answer));

onChange(() => {
  stopBar.hidden = !mayOperate();
  stop.classList.toggle("idle", !now.running);
});

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && event.shiftKey && mayOperate()) press();
});
