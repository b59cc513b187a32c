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

$(chains)
