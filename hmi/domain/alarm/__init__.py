"""Alarms after ISA-18.2 and IEC 62682: their life, their catalogue, what came first, floods. Pure."""
