"""Running the cases of a plan: executors, workers, recording, retries, cost, clusters."""
