// The mission's geometry as the map draws it: pieces of path in driving order, and how far the robot is.

import { readAreas } from './areas.js';
import { cutAt, lineParts, mercPerMetre, mercX, mercY, nearestOn, polygonParts } from './geometry.js';

const PATH_KINDS = new Set(['row', 'turn', 'headland', 'approach', 'exit']);
const NEXT_ROWS = 2; // as many passes ahead as an operator looks for
const DEFAULT_WIDTH_M = 3;

/** Flat mercator [x, y, ...] of lon/lat positions. */
const flat = (line) => line.flatMap(([lon, lat]) => [mercX(lon), mercY(lat)]);

/**
 * Read mission GeoJSON: {pieces, parcels, homes, areas, rows, rowWidthM}.
 *
 * Path features come in driving order, so a piece's index is the robot's segment number.
 */
export function readMission(collection) {
  const features = collection?.features ?? [];
  const pieces = [];
  for (const feature of features) {
    const { kind, row, tool_on: tool, dose = 1 } = feature.properties ?? {};
    if (!PATH_KINDS.has(kind)) continue;
    for (const line of lineParts(feature.geometry)) {
      if (line.length > 1) pieces.push({ kind, row: kind === 'row' ? Number(row) || 0 : 0, isWorked: tool ?? kind === 'row', dose, line: flat(line) });
    }
  }
  const of = (kind) => features.filter((f) => f.properties?.kind === kind);
  return {
    pieces,
    parcels: of('parcel').filter((f) => polygonParts(f.geometry).length),
    homes: of('home'),
    areas: readAreas(features),
    rows: pieces.reduce((most, piece) => Math.max(most, piece.row), 0),
    rowWidthM: rowWidth(pieces, features),
  };
}

/** Working width: as declared, else the median distance of neighbouring rows. */
function rowWidth(pieces, features) {
  const declared = features.map((f) => Number(f.properties?.width_m)).find((w) => w > 0);
  if (declared) return declared;
  const rows = pieces.filter((p) => p.kind === 'row');
  const gaps = [];
  for (let i = 0; i + 1 < rows.length && gaps.length < 40; i += 1) {
    if (rows[i + 1].row === rows[i].row) continue;
    const { line } = rows[i];
    const middle = 2 * Math.floor(line.length / 4);
    const x = (line[middle] + line[Math.max(middle - 2, 0)]) / 2;
    const y = (line[middle + 1] + line[Math.max(middle - 1, 1)]) / 2;
    gaps.push(nearestOn(rows[i + 1].line, x, y).off / mercPerMetre(y));
  }
  gaps.sort((a, b) => a - b);
  return gaps.length ? Math.min(Math.max(gaps[gaps.length >> 1], 0.2), 60) : DEFAULT_WIDTH_M;
}

/**
 * How far the robot is: {at, behind, ahead, nextEnd}; piece indices and flat mercator lines.
 *
 * `at` is -1 before the first piece and `pieces.length` when all is done. `pose` is {mx, my} or null.
 */
export function progress(model, mission, pose) {
  const { pieces } = model;
  const nothing = { at: -1, behind: [], ahead: [], nextEnd: Math.min(pieces.length, 1) };
  if (!pieces.length || !mission) return nothing;
  if (mission.status === 'done') return { at: pieces.length, behind: [], ahead: [], nextEnd: pieces.length };
  if (!['running', 'paused', 'aborted', 'failed'].includes(mission.status)) return nothing;
  const at = pieceAt(pieces, mission, pose);
  if (at < 0) return nothing;
  const piece = pieces[at];
  const along = alongPiece(piece.line, mission, pose, model.rowWidthM);
  const [behind, ahead] = cutAt(piece.line, along);
  return { at, behind, ahead, nextEnd: endOfNext(pieces, at) };
}

/** Index of the piece the robot is on: its own segment number, else its row, nearest to where it is. */
function pieceAt(pieces, mission, pose) {
  const { segment, row } = mission;
  if (Number.isInteger(segment) && segment >= 0 && segment < pieces.length && agrees(pieces, segment, row)) return segment;
  if (!(row > 0)) return -1;
  let best = -1;
  let off = Infinity;
  pieces.forEach((piece, i) => {
    if (piece.row !== row) return;
    const distance = pose ? nearestOn(piece.line, pose.mx, pose.my).off : 0;
    if (distance < off) [best, off] = [i, distance];
  });
  return best;
}

/** A segment number that contradicts the row is not trusted: the row is what the operator reads beside the map. */
function agrees(pieces, segment, row) {
  const piece = pieces[segment];
  return piece.kind !== 'row' || !(row > 0) || piece.row === row;
}

/** Where on the piece the robot is: under its pose when that is near the line, else by the metres it reports. */
function alongPiece(line, mission, pose, widthM) {
  const perMetre = mercPerMetre(line[1]);
  if (pose) {
    const { along, off } = nearestOn(line, pose.mx, pose.my);
    if (off < widthM * 1.5 * perMetre) return along;
  }
  return (mission.segment_s_m ?? 0) * perMetre;
}

/** One past the last piece of the next rows, turns between them included. */
function endOfNext(pieces, at) {
  const seen = new Set();
  for (let i = at + 1; i < pieces.length; i += 1) {
    const { row } = pieces[i];
    if (row && row !== pieces[at].row) seen.add(row);
    if (seen.size > NEXT_ROWS) return i;
  }
  return pieces.length;
}
