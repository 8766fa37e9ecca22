"""Telling people outside the screen of alarms: webhooks and e-mail, with limits, retries and hidden secrets."""
