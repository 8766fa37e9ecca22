// What a map does where its page says nothing else.

export const LOST_CONTEXT_MS = 3000;
export const USUAL = {
  mode: 'robot', hasButtons: true, engine: 'auto',
  featuresUrl: '/api/v1/features', missionUrl: '/api/v1/robots/{id}/mission.geojson',
  baseMapsUrl: '/api/v1/base-maps',
};
