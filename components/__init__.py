"""Building blocks of the screens: values in, callbacks out; they know no store and no client."""
