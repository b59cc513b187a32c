# Makes the body of the folder that make runs in, anywhere, with the programs in the folder BIN. `cad2fem new` writes
# a Makefile that includes this file.

include $(dir $(lastword $(MAKEFILE_LIST)))chain.mk

.DEFAULT_GOAL := all

override BIN := $(BIN)
$(call refuse,CURDIR BIN)

FOLDER := .
ELSEWHERE := .

.PHONY: all clean setup

all: ./build/done
	$(call tell,$<)

clean:
	rm -rf build

# the programs are there
setup:

# A body with rules of its own is called there as the body that it is like.
ifneq ($(LIKE),)
from.$(LIKE) := .
to.$(LIKE) := ./build
endif

$(chains)

ifneq ($(LIKE),)
include rules.mk
endif

$(look-at-sources)
