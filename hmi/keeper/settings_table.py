"""The settings as a Markdown table, made from their definition for ``docs/operations.md``."""

from __future__ import annotations

from hmi.settings import Settings


def settings_table() -> str:
    """Return one row per setting: variable, default, meaning."""
    rows = ["| setting | variable | default | meaning |", "|---|---|---|---|"]
    for name, field in Settings.model_fields.items():
        default = "" if field.default in (None, "") or field.default_factory else f"`{field.default}`"
        rows.append(f"| `{name}` | `HEADLAND_{name.upper()}` | {default} | {field.description} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(settings_table())  # noqa: T201 - the table is the output
