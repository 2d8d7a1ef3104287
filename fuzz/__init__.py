"""A structure-aware, seeded fuzzer: whatever a file or word says, amble reads it or refuses it in one sentence."""
