// Where drawing begins on a farm that has no map yet.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import vm from 'node:vm';

import { sitesOf } from '../../static/js/editor/sites.js';

const HL = { maps: {}, units: {} };
vm.runInNewContext(fs.readFileSync(new URL('../../static/js/ui/maps_measure.js', import.meta.url), 'utf8'), { HL, window: {} });
const site = (robots) => sitesOf(JSON.parse(JSON.stringify(HL.maps.groundAround(robots))))[0] ?? []; // as the surface looks at it
const places = (found) => found.flatMap((one) => one.geometry.coordinates);

test('an empty farm is looked at where most robots stand, as near as a field is drawn', () => {
  const farm = [{ lon: 4.6, lat: 51.9 }, { lon: 4.601, lat: 51.9 }];
  const found = places(site([{ lon: 9.7, lat: 52.4 }, ...farm, { lon: null, lat: null }, {}]));
  assert.equal(found.length, 4);
  const [lons, lats] = [found.map(([lon]) => lon), found.map(([, lat]) => lat)];
  assert.ok(Math.min(...lons) > 4.59 && Math.max(...lons) < 4.61 && Math.min(...lats) > 51.89 && Math.max(...lats) < 51.91);
  assert.ok(Math.max(...lats) - Math.min(...lats) > 0.002, 'some hundred metres');
});

test('where no robot says where it is, there is no such place', () => {
  assert.deepEqual(site([{ name: 'Weeder' }, { lat: null, lon: null }]), []);
});

test('fields make a site before any number of other things', () => {
  const one = (kind, lon) => ({ properties: { kind }, geometry: { type: 'Polygon', coordinates: [[[lon, 52], [lon + 0.001, 52], [lon, 52.001], [lon, 52]]] } });
  const [first, ...others] = sitesOf([one('road', 9), one('road', 9.01), one('home', 9.02), one('parcel', 5)]);
  assert.deepEqual([first.length, others.map((site) => site.length)], [1, [3]]);
});
