"""What every room needs: errors, words, arrays, equality."""
