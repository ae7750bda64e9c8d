#!/bin/sh
# Checks that `man` formats our man pages without warnings: manual.sh SHARE
status=0
for page in "$1"/man/man1/*.1.gz; do
  warnings=$(MANWIDTH=80 man -l --warnings "$page" 2>&1 >/dev/null)
  [ -z "$warnings" ] || { echo "$page: $warnings"; status=1; }
  MANWIDTH=80 man -l "$page" | grep -q "EXIT STATUS" || { echo "$page: not formatted"; status=1; }
done
exit $status
