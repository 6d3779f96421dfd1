"""The pair in a browser, on this machine alone: `mixed-ehl app`."""
