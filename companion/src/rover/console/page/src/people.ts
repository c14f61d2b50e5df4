// Pairing, and whose the operator's seat is.
import { get, post } from "./api";
import { button, field, fill, h } from "./dom";
import { attempt, changed, live, mayOperate, now, onChange, operates } from "./shared";
import { t } from "./strings";

export const seat = h("div", { class: "seat", "aria-live": "polite" });

async function wish(content: object): Promise<void> {
  now.people = { ...now.people, ...(await post("seat", content as Record<string, unknown>)) };
  changed();
}

function draw(): void {
  const people = now.people;
  if (!people) { fill(seat); return; }
  const name = people.operator?.name;
  const who = operates() ? t("operator_you") : name ? t("operator_is", { name }) : t("operator_none");
  const asking = operates() ? (people.people ?? []).filter((each: any) => each.asks) : [];
  fill(
    seat,
    h("span", {}, who),
    !mayOperate() && h("span", {}, t("looks_on")),
    mayOperate() && !operates() && button(name ? t("ask_seat") : t("take_seat"), () => attempt(() => wish({ wish: "take" }))),
    ...asking.map((each: any) => h("span", { class: "asking" }, t("asks", { name: each.name }), " ",
      button(t("hand_to", { name: each.name }), () => attempt(() => wish({ wish: "give", to: each.number }))))),
    operates() && button(t("free_seat"), () => attempt(() => wish({ wish: "give", to: null }))),
    button(t("leave"), () => attempt(async () => { await post("leave"); location.reload(); })),
  );
}

onChange(draw);
live.on("people", (people) => { now.people = people; changed(); });

/** Resolves when this browser has a session. */
export async function paired(page: HTMLElement): Promise<void> {
  const me = await get("me");
  if (me.me) { now.people = me; return; }
  const code = h("input", { type: "text", autocomplete: "one-time-code", autocapitalize: "characters", spellcheck: "false", required: true });
  const name = h("input", { type: "text", autocomplete: "nickname", maxlength: 40 });
  const told = h("p", { role: "alert" });
  await new Promise<void>((done) => {
    const form = h("form", {
      class: "card pair",
      submit: (event: Event) => {
        event.preventDefault();
        post("pair", { code: code.value, name: name.value })
          .then((people) => { now.people = people; done(); }, (error: Error) => { told.textContent = error.message; });
      },
    }, h("h1", {}, t("pair_title")), h("p", {}, t("pair_help")), field(t("code"), code), field(t("your_name"), name),
    h("button", { type: "submit" }, t("pair")), told);
    fill(page, h("main", {}, form));
    code.focus();
  });
}
