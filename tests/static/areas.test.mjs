// Areas of a mission on the map.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { AreaLines, doseText, readAreas } from '../../static/js/map/areas.js';
import { farmLabels } from '../../static/js/map/captions.js';
import { asides } from '../../static/js/map/labels.js';
import { readMission } from '../../static/js/map/mission.js';

const row = (number, tool_on, dose) => ({
  type: 'Feature',
  properties: { kind: 'row', row: number, tool_on, ...(dose === undefined ? {} : { dose }) },
  geometry: { type: 'LineString', coordinates: [[4.26 + number / 1e5, 51.78], [4.26 + number / 1e5, 51.781]] },
});
const area = (kind, more = {}) => ({
  type: 'Feature',
  properties: { kind, ...more },
  geometry: { type: 'Polygon', coordinates: [[[4.26, 51.78], [4.261, 51.78], [4.261, 51.781], [4.26, 51.78]]] },
});
const features = [row(1, true), row(1, false), row(2, true, 0.5), row(3, true, 2), area('dose', { dose: 0 }), area('obstacle'), area('leave_out'), area('parcel')];
const model = readMission({ features });
const ink = { bed: 1, row: 2, path: 3, obstacle: 4 };

test('a piece of a row with the tool off is not drawn as worked', () => {
  assert.deepEqual(model.pieces.map((one) => one.isWorked), [true, false, true, true]);
});

test('a row without a word about its tool is worked', () => {
  assert.equal(readMission({ features: [row(1, undefined)] }).pieces[0].isWorked, true);
});

test('every area has its words', () => {
  assert.deepEqual(readAreas(features).map((one) => one.text), ['Off', 'Obstacle', 'Left out']);
  assert.deepEqual([0.5, 1, 1.5, 2].map(doseText), ['Half dose', 'Usual dose', '1.5 × dose', 'Double dose']);
});

test('less is dashed and more is broad; outlines stay when rows are hidden', () => {
  const lines = new AreaLines();
  lines.lay(model, { mx: 0.5, my: 0.33 });
  const drawn = lines.lines(3, ink, true);
  assert.deepEqual(drawn.map((one) => [one.colour, Boolean(one.dash)]), [[1, true], [2, false], [3, true], [4, false]]);
  assert.deepEqual(lines.lines(3, ink, false).map((one) => one.colour), [3, 4]);
  lines.lay(null, { mx: 0.5, my: 0.33 });
  assert.deepEqual(lines.lines(3, ink, true), []);
});

test('the name of a field moves aside on its own ground only', () => {
  const ring = [[4.26, 51.78], [4.264, 51.78], [4.264, 51.784], [4.26, 51.784], [4.26, 51.78]];
  const [label] = farmLabels([{ properties: { kind: 'parcel', name: 'Oostveld' }, geometry: { type: 'Polygon', coordinates: [ring] } }]);
  const worldPx = 50 / label.room[0]; // the field goes on for 50 px to the north
  assert.ok(Math.abs(label.room[1] * worldPx - 50) < 0.1);
  assert.deepEqual(asides(label, 1, worldPx), [0, -34, 34]);
  assert.deepEqual(asides(label, 1, worldPx / 2), [0]);
});
