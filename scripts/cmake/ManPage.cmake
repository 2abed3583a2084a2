# cmake -DPROGRAM=FILE -DVERSION=... -DPAGE=FILE.1 -P ManPage.cmake: manual page from the program's --help, so that both
# agree. The first line of the help becomes the NAME line.
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
get_filename_component(name ${PROGRAM} NAME)
string(TOUPPER ${name} title)

string(REPLACE "\\" "\\e" help "${help}")
string(REPLACE "-" "\\-" help "${help}")
string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" help "${help}")
string(REGEX MATCH "^[^\n]+" summary "${help}")
string(REGEX REPLACE "^VRDA: |\\.$" "" summary "${summary}")

file(WRITE ${PAGE} ".TH ${title} 1 \"\" \"VRDA ${VERSION}\"
.SH NAME
${name} \\- ${summary}
.SH DESCRIPTION
.nf
${help}.fi
")
