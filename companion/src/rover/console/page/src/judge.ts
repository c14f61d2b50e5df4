// Judge: what people say of indications. It is kept beside the run, and changes nothing that the rover keeps out of.
import { get, post, type Json } from "./api";
import { button, choice, choose, field, fill, h, number, section } from "./dom";
import { judged } from "./field";
import { Picture } from "./picture";
import { attempt, live, mayOperate, now, onChange } from "./shared";
import { t, word } from "./strings";

const path = (run: string) => `runs/${encodeURIComponent(run)}`;

export function judge() {
  let run = "";
  let places: Json[] = [];
  let living: Json[] = [];
  let judgements: Json[] = [];
  let chosen: number | null = null;

  const runs = choice([]);
  const list = h("ul", { class: "indications" });
  const detail = h("div", { class: "detail", "aria-live": "polite" }, t("judge_choose"));
  const journal = h("ol", { class: "events", tabindex: 0, "aria-label": t("journal") });
  const x = h("input", { type: "number", step: "0.01" });
  const y = h("input", { type: "number", step: "0.01" });
  const markNote = h("input", { type: "text", maxlength: 500 });
  const mark = button(t("mark"), () => attempt(() => add({ verdict: "marked", x: Number(x.value), y: Number(y.value), note: markNote.value })));

  async function add(content: Json): Promise<void> {
    await post(`${path(run)}/judgements`, content);
    await load();
  }

  async function load(): Promise<void> {
    if (!run) return;
    const told = await get(path(run));
    judgements = told.judgements;
    places = told.summary.detections ?? (run === now.running ? living : []);
    draw();
  }

  function draw(): void {
    const { verdicts } = judged(judgements);
    const rows = places.map((place) => {
      const said = verdicts.get(place.id);
      const chip = h("span", { class: `chip ${said?.verdict ?? ""}` }, said ? word(said.verdict) : t("unjudged"));
      const open = button(t("indication", { id: place.id }), () => { chosen = place.id; draw(); show(place); },
        { "aria-pressed": String(chosen === place.id) });
      return h("li", {}, open, " ", `${place.class}, ${t("probability", { p: number(place.p) })}, ${where(place)} `, chip);
    });
    fill(list, ...(rows.length ? rows : [h("li", {}, t("judge_none"))]));
    fill(journal, ...[...judgements].reverse().map((each) => h("li", {},
      `${each.place !== undefined ? t("indication", { id: each.place }) : t("at", { x: each.x, y: each.y, s: "–" })}: `,
      t("judged_by", { verdict: word(each.verdict), author: each.author, utc: each.utc }), each.note ? `: ${each.note}` : "")));
  }

  function show(place: Json): void {
    const note = h("textarea", { rows: 2, maxlength: 500 });
    const say = (verdict: string) => () => attempt(() => add({ verdict, place: place.id, note: note.value }));
    const views = h("div", { class: "views" });
    fill(detail,
      h("h3", {}, t("indication", { id: place.id })),
      h("p", {}, `${place.class}, ${t("probability", { p: number(place.p) })}, ${where(place)}`),
      field(t("note"), note),
      h("div", { class: "row" }, button(t("confirm"), say("confirmed"), { disabled: !mayOperate() }), button(t("reject"), say("rejected"), { disabled: !mayOperate() })),
      h("h3", {}, t("pictures")), views);
    attempt(async () => {
      const told = await get(`${path(run)}/places/${place.id}?x=${place.x}&y=${place.y}`);
      const shown = told.views.map((view: Json) => {
        const picture = new Picture();
        void picture.show(`api/${path(run)}/pictures/${view.picture}`, [view], view.t);
        return h("figure", {}, picture.canvas, h("figcaption", {}, `${number(view.t, 1)} s`));
      });
      fill(views, ...(shown.length ? shown : [t("pictures_none")]));
    });
  }

  function where(place: Json): string {
    return t("at", { x: number(place.x), y: number(place.y), s: number(place.sigma_m) });
  }

  runs.addEventListener("change", () => { run = now.shown = runs.value; chosen = null; fill(detail, t("judge_choose")); attempt(load); });
  live.on("state", (state) => {
    living = state.places;
    if (run === now.running && !element.hidden) { places = living; draw(); }
  });
  onChange(() => {
    choose(runs, now.runs.map((each) => [each.name, each.name]), now.shown);
    if (runs.value !== run && !element.hidden) { run = runs.value; attempt(load); }
    mark.disabled = !mayOperate();
  });

  const element = h("div", { class: "page aside" },
    h("div", { class: "column" },
      section(t("judge"), field(t("choose_run"), runs), h("p", { class: "hint" }, t("judge_help")), list),
      section(t("marks"), h("div", { class: "fields" }, field(t("launch_x"), x), field(t("launch_y"), y), field(t("mark_note"), markNote)), mark),
      section(t("journal"), journal)),
    h("div", { class: "column wide" }, h("div", { class: "card" }, detail)));
  return { element, shown: () => { run = runs.value; attempt(load); } };
}
