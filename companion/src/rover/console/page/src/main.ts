// The page's frame: pairing first, then four pages under one header, with the emergency stop over all of them.
import "./style.css";
import { fill, h } from "./dom";
import { drive } from "./drive";
import { judge } from "./judge";
import { paired, seat } from "./people";
import { plan } from "./plan";
import { review } from "./review";
import { attempt, changed, live, refreshRuns, status, tell } from "./shared";
import { stopBar } from "./stop";
import { t, type Key } from "./strings";

interface Page { element: HTMLElement; shown(): void }

const PAGES: [Key, () => Page][] = [["plan", plan], ["drive", drive], ["judge", judge], ["review", review]];
const REFRESH_MS = 4000;

async function begin(): Promise<void> {
  document.title = t("title");
  const root = document.getElementById("page");
  if (!root) return;
  await paired(root);
  const pages = PAGES.map(([name, make]): [Key, Page] => [name, make()]);
  const main = h("main", { id: "content", tabindex: -1 }, ...pages.map(([, page]) => page.element));
  const links = pages.map(([name]) => h("a", { href: `#${name}` }, t(name)));
  fill(
    root,
    h("a", { class: "skip", href: "#content", click: (event: Event) => { event.preventDefault(); main.focus(); } }, t("skip_link")),
    h("header", {}, h("h1", {}, t("title")), h("nav", { "aria-label": t("pages") }, ...links), seat),
    main,
    h("footer", {}, status),
    stopBar,
  );
  const route = () => {
    const wanted = location.hash.slice(1);
    const name = pages.some(([each]) => each === wanted) ? wanted : "drive";
    pages.forEach(([each, page], index) => {
      page.element.hidden = each !== name;
      if (each === name) { links[index]?.setAttribute("aria-current", "page"); page.shown(); }
      else links[index]?.removeAttribute("aria-current");
    });
  };
  window.addEventListener("hashchange", route);
  live.on("closed", () => tell(t("connection_lost")));
  live.on("open", () => tell(t("connection_back")));
  live.open("");
  await refreshRuns();
  setInterval(() => attempt(refreshRuns), REFRESH_MS);
  changed();
  route();
}

void begin().catch((error: Error) => {
  document.getElementById("page")?.append(h("p", { role: "alert" }, error.message));
});
