// Metres around a point of the ground: flat, true to a millimetre over a field.

import { DEG } from './geometry.js';

const EQUATOR_M = 40075016.685578488;
const FLATTENING = 0.00669438; // first eccentricity squared of WGS84
const PLACES = 1e8; // 8 decimals of a degree are a millimetre

export class Plane {
  constructor([lon, lat]) {
    const bulge = 1 - FLATTENING * Math.sin(lat * DEG) ** 2;
    this.lon = lon;
    this.lat = lat;
    this.east = ((EQUATOR_M / 360) * Math.cos(lat * DEG)) / Math.sqrt(bulge);
    this.north = ((EQUATOR_M / 360) * (1 - FLATTENING)) / bulge ** 1.5;
  }

  /** [lon, lat] -> [metres east, metres north]. */
  toM([lon, lat]) {
    return [(lon - this.lon) * this.east, (lat - this.lat) * this.north];
  }

  toLonLat([east, north]) {
    return [this.lon + east / this.east, this.lat + north / this.north];
  }
}

/** Metres between two positions. */
export function lengthM(a, b) {
  const [east, north] = new Plane([(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]).toM(a);
  return 2 * Math.hypot(east, north);
}

/** Degrees clockwise from north, 0 to 360, from one position to the other. */
export function bearingDeg(from, to) {
  const [east, north] = new Plane(from).toM(to);
  return (Math.atan2(east, north) / DEG + 360) % 360;
}

/** The position so many metres away. */
export function shifted(position, east, north) {
  return new Plane(position).toLonLat([east, north]);
}

/** A position as it is kept: 8 decimals, height left as it was. */
export function kept([lon, lat, ...height]) {
  return [Math.round(lon * PLACES) / PLACES, Math.round(lat * PLACES) / PLACES, ...height];
}
