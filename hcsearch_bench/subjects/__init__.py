"""What several benches measure on."""
