#include "cockpit.hpp"

namespace driveline::endpoint {

std::string_view cockpit_page() noexcept {
  return R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Drive</title>
<style>
  :root { color-scheme: light dark; --ink: #1c2430; --quiet: #5d6876; --paper: #f4f6f8; --card: #ffffff; --line: #d9dfe6;
          --good: #1a7f4b; --bad: #b3261e; --lit: #ff3b30; }
  @media (prefers-color-scheme: dark) {
    :root { --ink: #e6ebf1; --quiet: #93a0af; --paper: #12161c; --card: #1b212a; --line: #2d3642; --good: #4cc38a; --bad: #ff7b72; }
  }
  * { box-sizing: border-box; }
  body { margin: 0; font: 15px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper); }
  header { display: flex; flex-wrap: wrap; gap: 1rem 2rem; align-items: center; padding: 1rem 1.5rem; background: var(--card);
           border-bottom: 1px solid var(--line); }
  h1 { margin: 0; font-size: 1.25rem; }
  h2 { margin: 0 0 .5rem; font-size: .8rem; letter-spacing: .06em; text-transform: uppercase; color: var(--quiet); }
  .sub { color: var(--quiet); }
  .display { font: 700 2.1rem/1 ui-monospace, monospace; letter-spacing: .15em; color: var(--lit); background: #180403;
             padding: .45rem .6rem; border-radius: .3rem; min-width: 4.2rem; text-align: center; white-space: pre; }
  main { display: grid; grid-template-columns: repeat(auto-fit, minmax(18rem, 1fr)); gap: 1rem; padding: 1rem 1.5rem; }
  section { background: var(--card); border: 1px solid var(--line); border-radius: .5rem; padding: .9rem 1rem; }
  table { width: 100%; border-collapse: collapse; }
  td { padding: .18rem 0; vertical-align: top; }
  td:last-child { text-align: right; font-variant-numeric: tabular-nums; }
  td:first-child { color: var(--quiet); padding-right: 1rem; }
  .badge { padding: .1rem .5rem; border-radius: 1rem; border: 1px solid currentColor; font-size: .85rem; }
  .good { color: var(--good); } .bad { color: var(--bad); }
  footer { padding: 0 1.5rem 1.5rem; color: var(--quiet); font-size: .85rem; }
  footer a { color: inherit; }
</style>
</head>
<body>
<header>
  <div class="display" id="display" title="seven-segment display"> </div>
  <div><h1 id="title">Drive</h1><div class="sub" id="type"></div></div>
  <div><span class="badge" id="state"></span> <span class="badge" id="al"></span></div>
  <div class="bad" id="message"></div>
</header>
<main>
  <section><h2>Actual values</h2><table id="values"></table></section>
  <section><h2>Drive</h2><table id="drive"></table></section>
  <section><h2>Network</h2><table id="network"></table></section>
  <section><h2>Identity</h2><table id="identity"></table></section>
  <section><h2>Parameters</h2><table id="parameters"></table></section>
</main>
<footer>Simulated by driveline. The same as a document: <a href="/state.json">/state.json</a>. <span id="age"></span></footer>
<script>
  "use strict";
  const at = id => document.getElementById(id);
  const words = key => key.replace(/_/g, " ");
  function fill(id, rows) {
    const body = document.createElement("tbody");
    for (const [name, value] of rows) {
      const row = body.insertRow();
      row.insertCell().textContent = name;
      row.insertCell().textContent = value;
    }
    at(id).replaceChildren(body);
  }
  const number = value => Number.isInteger(value) ? value.toLocaleString("en") : value.toPrecision(6);
  const measured = list => list.map(v => [v.name, number(v.value) + (v.unit ? " " + v.unit : "")]);
  const plain = object => Object.entries(object).map(([key, value]) => [words(key), String(value)]);
  function mark(id, text, good) {
    at(id).textContent = text;
    at(id).className = "badge " + (good ? "good" : "bad");
    at(id).hidden = !text;
  }
  function show(s) {
    document.title = s.identity.name || s.identity.type || "Drive";
    at("title").textContent = document.title;
    at("type").textContent = [s.identity.maker, s.identity.type, s.identity.firmware].filter(Boolean).join(" · ");
    at("display").textContent = s.drive.display || " ";
    mark("state", s.drive.state, !s.drive.fault);
    mark("al", s.network.al_state, s.network.al_state !== "INIT");
    at("message").textContent = s.drive.fault ? s.drive.message : "";
    fill("values", measured(s.values));
    fill("parameters", measured(s.parameters));
    fill("drive", plain(s.drive));
    fill("network", plain(s.network));
    fill("identity", plain(s.identity));
    at("age").textContent = "Running for " + s.running_s + " s.";
  }
  async function refresh() {
    try {
      const answer = await fetch("/state.json", { cache: "no-store", signal: AbortSignal.timeout(3000) });
      show(await answer.json());
    } catch (error) {
      at("age").textContent = "No answer from the drive.";
    }
    setTimeout(refresh, 500);
  }
  refresh();
</script>
</body>
</html>
)html";
}

}  // namespace driveline::endpoint
