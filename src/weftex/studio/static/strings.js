/** The page's words: one JSON file a language in strings/, English where one is missing. */

let words = {};
let english = {};
let language = "en";
let messages = {}; // of the library: translations by English templates with {0}, {1}
let templates = []; // [pattern, translation], those that say most first

async function load(language, folder = "strings") {
  const answer = await fetch(new URL(`${folder}/${language}.json`, import.meta.url));
  return answer.ok ? answer.json() : null;
}

/** Load the language that is chosen, or the first of the browser's that there is; returns its code. */
export async function loadStrings(chosen) {
  english = await load("en");
  words = english;
  const known = english["languages"].split(" ");
  const asked = [chosen, ...(navigator.languages ?? [navigator.language])].map((one) => one?.split("-")[0]);
  const wanted = asked.find((one) => known.includes(one)) ?? "en";
  if (wanted !== "en") {
    const [own, said] = await Promise.all([load(wanted), load(wanted, "messages")]);
    words = own || english;
    messages = said ?? {};
    const holes = Object.entries(messages).filter(([template]) => template.includes("{"));
    holes.sort(([one], [other]) => other.length - one.length);
    templates = holes.map(([template, translation]) => [patternOf(template), translation]);
  }
  language = words === english ? "en" : wanted;
  document.documentElement.lang = language;
  return language;
}

/** The text of a key, with {name} replaced by values. */
export function t(key, values = {}) {
  const text = words[key] ?? english[key] ?? key;
  return text.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}

function patternOf(template) {
  const parts = template.split(/\{\d\}/).map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, "\\$&"));
  return new RegExp(`^${parts.join("(.+?)")}$`);
}

/** What the library says, in the page's language where a translation is known, and in English elsewhere. */
export function said(text) {
  if (!text || messages[text]) return messages[text] ?? text;
  for (const [pattern, translation] of templates) {
    const found = pattern.exec(text);
    if (found) return translation.replace(/\{(\d)\}/g, (_, k) => said(found[Number(k) + 1]));
  }
  return text.includes("; ") ? text.split("; ").map(said).join("; ") : text;
}

/** Whether a key has words. */
export function has(key) {
  return key in words || key in english;
}

/** A number as people of the language write it, with so many digits after the point at most. */
export function number(value, digits = 0) {
  return new Intl.NumberFormat(language, { maximumFractionDigits: digits }).format(value);
}

/** Seconds as "3 s", "2 min 10 s". */
export function duration(seconds) {
  if (seconds < 0.995) return t("time.ms", { n: number(Math.max(1, seconds * 1000)) });
  if (seconds < 90) return t("time.s", { n: number(seconds, seconds < 10 ? 1 : 0) });
  return t("time.min", { n: Math.floor(seconds / 60), s: Math.round(seconds % 60) });
}

/** What a job is doing and how much of it is done, in words, and as a share. */
export function progressOf(job) {
  if (!job) return { text: t("job.starting"), share: 0 };
  const share = job.total ? job.done / job.total : 0;
  const [stage, now] = job.stage.split(", now ");
  const doing = job.state === "waiting" ? t(job.ahead ? "job.waiting" : "job.ending", { n: job.ahead }) : has(`job.${stage}`) ? t(`job.${stage}`) : job.stage || t("job.starting");
  const count = !job.total ? "" : job.total > 24 ? `${number(100 * share)} %` : t("job.count", { done: number(job.done), total: number(job.total) });
  const left = share > 0.2 && job.left >= 1 ? t("job.left", { time: duration(job.left) }) : "";
  return { text: [doing, now, count, left].filter(Boolean).join(" · "), share };
}
