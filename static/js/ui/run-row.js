// A row of a list of runs: pressed, the run is shown; beside it, what removes it.

import { icon, make } from "./element.js";

/**
 * @param {{selected: {id: string} | null, may: boolean, choose: (id: string) => void}} model
 * @param {{id: string}} run
 * @param {{drawing: string, name: string, note: string}} words
 * @param {HTMLElement | false} away
 */
export function runRow(model, run, { drawing, name, note }, away) {
  const shown = run.id === model.selected?.id;
  const words = make("span", make("b", name), make("span.note", note));
  const open = make(
    "button.row-open",
    { "aria-current": shown ? "true" : null, onclick: () => model.choose(run.id) },
    icon(drawing),
    words,
  );
  return make("li", open, model.may && away);
}
