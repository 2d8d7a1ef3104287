"""The parts of the check of a gait: numbers and dense solves, apart from the transcription that made the gait."""
