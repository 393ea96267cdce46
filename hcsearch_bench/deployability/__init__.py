"""The bench `deployability`: what becomes of all untwisted foldings of many arrays."""
