within MacroStep;
package Examples "Blocks with values, and a system of three"
end Examples;
