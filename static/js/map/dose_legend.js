// What the patterns of doses mean. Only missions with more than one dose need it, so it is fetched with the first of those.

const KEYS = [['usual', 'Usual dose'], ['less', 'Less'], ['more', 'More'], ['off', 'Off or left out']];

/** Keys of what there is to explain on a mission; none where every row is worked with the usual dose. */
export function dosesOf(model) {
  const doses = new Set((model?.pieces ?? []).filter((one) => one.isWorked).map((one) => (one.dose === 1 ? 'usual' : one.dose < 1 ? 'less' : 'more')));
  if (model?.areas.some((one) => one.kind !== 'obstacle') && model.pieces.some((one) => one.kind === 'row' && !one.isWorked)) doses.add('off');
  return doses.size > 1 || doses.has('off') ? doses : new Set();
}

/** Hidden while the mission has nothing to explain. */
export class DoseLegend {
  constructor(host) {
    this.node = document.createElement('div');
    this.node.className = 'hl-map-doses';
    this.node.dataset.testid = 'map-doses';
    this.node.hidden = true;
    host.append(this.node);
  }

  show(model) {
    const doses = dosesOf(model);
    this.node.hidden = doses.size === 0;
    this.node.replaceChildren(...KEYS.filter(([key]) => doses.has(key)).map(([key, words]) => {
      const line = document.createElement('span');
      const sign = document.createElement('i');
      sign.className = key;
      line.append(sign, words);
      return line;
    }));
  }
}
