"""The camera process: pulls cameras while somebody looks, encodes each once and hands the packets to all."""
