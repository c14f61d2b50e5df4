// Elements are made here and nowhere else: what comes from outside becomes text, never markup.
type Child = Node | string | number | null | undefined | false;
type Attributes = Record<string, string | number | boolean | EventListener | undefined>;

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== undefined) element.setAttribute(name, String(value));
  }
  fill(element, ...children);
  return element;
}

export function fill(element: Element, ...children: Child[]): void {
  element.replaceChildren(
    ...children.filter((each) => each !== null && each !== undefined && each !== false)
      .map((each) => (each instanceof Node ? each : document.createTextNode(String(each)))),
  );
}

export function button(text: string, action: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return h("button", { type: "button", click: action, ...attributes }, text);
}

let numbers = 0;

/** A labelled control. */
export function field<T extends HTMLElement>(label: string, control: T): HTMLDivElement {
  control.id ||= `control-${++numbers}`;
  return h("div", { class: "field" }, h("label", { for: control.id }, label), control);
}

export function choice(options: [string, string][], value = ""): HTMLSelectElement {
  const select = h("select", {});
  choose(select, options, value);
  return select;
}

export function choose(select: HTMLSelectElement, options: [string, string][], value?: string): void {
  const kept = value ?? select.value;
  const same = [...select.options].map((each) => each.value).join("\n") === options.map(([v]) => v).join("\n");
  if (!same) fill(select, ...options.map(([v, text]) => h("option", { value: v }, text)));
  if (options.some(([v]) => v === kept)) select.value = kept;
}

export function section(title: string, ...children: Child[]): HTMLElement {
  const id = `title-${++numbers}`;
  return h("section", { "aria-labelledby": id, class: "card" }, h("h2", { id }, title), ...children);
}

export function number(value: unknown, digits = 2): string {
  return typeof value === "number" && Number.isFinite(value) ? value.toFixed(digits) : "–";
}

export function minutes(seconds: unknown): string {
  if (typeof seconds !== "number") return "–";
  return seconds < 90 ? `${Math.round(seconds)} s` : `${(seconds / 60).toFixed(0)} min`;
}
