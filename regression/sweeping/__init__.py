"""Running the cases of a plan: executors, workers, recording, retries, cost, clusters."""

from __future__ import annotations
