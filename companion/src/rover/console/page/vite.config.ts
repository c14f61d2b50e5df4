// Builds the page into ../built: what is committed there is served as it is, and a test compares SOURCES with the hash
// of what it was built from.
import { createHash } from "node:crypto";
import { existsSync, readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, relative, sep } from "node:path";
import { defineConfig, type Plugin } from "vite";

const here = import.meta.dirname;
const built = join(here, "..", "built");
const SOURCES = ["index.html", "package-lock.json", "package.json", "src", "tsconfig.json", "vite.config.ts"];

function filesOf(path: string): string[] {
  return statSync(path).isDirectory() ? readdirSync(path).flatMap((name) => filesOf(join(path, name))) : [path];
}

function sourceHash(): string {
  const digest = createHash("sha256");
  const files = SOURCES.flatMap((name) => filesOf(join(here, name)));
  const named = files.map((file): [string, string] => [relative(here, file).split(sep).join("/"), file]);
  for (const [name, file] of named.sort(([a], [b]) => (a < b ? -1 : 1))) {
    digest.update(name + "\0").update(readFileSync(file)).update("\0");
  }
  return digest.digest("hex");
}

// The licences of what the bundle holds, beside it.
function licences(): Plugin {
  return {
    name: "licences",
    generateBundle(_, bundle) {
      const folders = new Set<string>();
      for (const chunk of Object.values(bundle)) {
        if (chunk.type !== "chunk") continue;
        for (const id of Object.keys(chunk.modules)) {
          const found = /^(.*\/node_modules\/(?:@[^/]+\/)?[^/]+)\//.exec(id.replace(/^\0/, ""));
          if (found?.[1] && existsSync(join(found[1], "package.json"))) folders.add(found[1]);
        }
      }
      const texts = [...folders].sort().map((folder) => {
        const about = JSON.parse(readFileSync(join(folder, "package.json"), "utf-8"));
        const file = readdirSync(folder).find((name) => /^licen[cs]e/i.test(name));
        const text = file ? readFileSync(join(folder, file), "utf-8").trim() : "";
        return `${about.name} ${about.version}, ${about.license}\n\n${text}\n`;
      });
      this.emitFile({ type: "asset", fileName: "LICENCES.txt", source: texts.join("\n----\n\n") });
    },
    closeBundle() {
      writeFileSync(join(built, "SOURCES"), sourceHash() + "\n");
    },
  };
}

export default defineConfig({
  root: here,
  base: "./",
  plugins: [licences()],
  build: {
    outDir: built,
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1000,
    rollupOptions: {
      output: {
        entryFileNames: "assets/page.js",
        chunkFileNames: "assets/[name].js",
        assetFileNames: "assets/[name][extname]",
      },
    },
  },
});
